"""Error messages for users."""

from __future__ import annotations

import pickle

import pytest

from kinmo.core.errors import MAX_PROBLEM_LENGTH, InputError, did_you_mean, expecting

FAMILIES = ("bottle", "dishwasher", "door_set", "faucet", "laptop", "microwave", "refrigerator", "safe", "table", "window")


@pytest.mark.parametrize("field", [None, "joints[2].axis"])
def test_an_error_survives_the_way_out_of_a_worker_process(field):
    error = InputError("a/b.json", "expected a number", field)
    found = pickle.loads(pickle.dumps(error))
    assert (str(found), found.where, found.problem, found.field) == (str(error), error.where, error.problem, field)


def test_an_error_about_data_names_the_file():
    with pytest.raises(InputError, match=r"^a\.json: expected numbers"), expecting("numbers", "a.json"):
        {}["absent"]


def test_messages_have_no_control_characters_and_quote_little() -> None:
    error = InputError(
        "a\nb.json", "expected \x1b[31m a number, got " + 10_000 * "7\u202e" + ": export it again", "joints\0" + 900 * "x"
    )
    assert str(error).isprintable() and error.problem.isprintable()
    assert str(error).startswith("a\\nb.json: joints xxx")
    assert str(error).endswith(": export it again"), "the remedy stays"
    assert len(error.problem) <= MAX_PROBLEM_LENGTH


def test_short_messages_stay_as_they_are() -> None:
    assert str(InputError("a  b.json", "expected\n 7", "x")) == "a  b.json: x: expected 7"


@pytest.mark.parametrize("name, meant", [("refridgerator", "refrigerator"), ("Door", "door_set"), ("LAPTOP", "laptop")])
def test_a_misspelt_name_suggests_the_most_similar_one(name: str, meant: str) -> None:
    assert did_you_mean(name, FAMILIES) == f" (did you mean {meant}?)"


def test_a_name_like_no_other_suggests_nothing() -> None:
    assert did_you_mean("xyzzy", FAMILIES) == "" == did_you_mean("laptop", ())
