"""Messages about a user's mistakes."""

from __future__ import annotations

import pickle

import pytest

from kinmo.core.errors import InputError, did_you_mean, expecting
from kinmo.synth.families import family_names


@pytest.mark.parametrize("field", [None, "joints[2].axis"])
def test_an_error_comes_out_of_a_worker_process_as_it_was(field):
    error = InputError("a/b.json", "expected a number", field)
    found = pickle.loads(pickle.dumps(error))
    assert (str(found), found.where, found.problem, found.field) == (str(error), error.where, error.problem, field)


def test_what_goes_wrong_with_data_names_the_file():
    with pytest.raises(InputError, match=r"^a\.json: expected numbers"), expecting("numbers", "a.json"):
        {}["absent"]


@pytest.mark.parametrize("name, meant", [("refridgerator", "refrigerator"), ("Door", "door_set"), ("LAPTOP", "laptop")])
def test_a_misspelt_name_brings_up_the_nearest(name: str, meant: str) -> None:
    assert did_you_mean(name, family_names()) == f" (did you mean {meant}?)"


def test_a_name_like_none_brings_up_none() -> None:
    assert did_you_mean("xyzzy", family_names()) == "" == did_you_mean("laptop", ())
