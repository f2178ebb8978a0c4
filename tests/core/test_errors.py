"""Error messages for users."""

from __future__ import annotations

import pickle

import pytest

from kinmo.core.errors import InputError, did_you_mean, expecting

FAMILIES = ("bottle", "dishwasher", "door_set", "faucet", "laptop", "microwave", "refrigerator", "safe", "table", "window")


@pytest.mark.parametrize("field", [None, "joints[2].axis"])
def test_an_error_survives_the_way_out_of_a_worker_process(field):
    error = InputError("a/b.json", "expected a number", field)
    found = pickle.loads(pickle.dumps(error))
    assert (str(found), found.where, found.problem, found.field) == (str(error), error.where, error.problem, field)


def test_an_error_about_data_names_the_file():
    with pytest.raises(InputError, match=r"^a\.json: expected numbers"), expecting("numbers", "a.json"):
        {}["absent"]


@pytest.mark.parametrize("name, meant", [("refridgerator", "refrigerator"), ("Door", "door_set"), ("LAPTOP", "laptop")])
def test_a_misspelt_name_suggests_the_most_similar_one(name: str, meant: str) -> None:
    assert did_you_mean(name, FAMILIES) == f" (did you mean {meant}?)"


def test_a_name_like_no_other_suggests_nothing() -> None:
    assert did_you_mean("xyzzy", FAMILIES) == "" == did_you_mean("laptop", ())
