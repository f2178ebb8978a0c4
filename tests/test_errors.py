from __future__ import annotations

import pickle

import pytest

from kinmo.errors import InputError, expecting


@pytest.mark.parametrize("field", [None, "joints[2].axis"])
def test_an_error_comes_out_of_a_worker_process_as_it_was(field):
    error = InputError("a/b.json", "expected a number", field)
    found = pickle.loads(pickle.dumps(error))
    assert (str(found), found.where, found.problem, found.field) == (str(error), error.where, error.problem, field)


def test_what_goes_wrong_with_data_names_the_file():
    with pytest.raises(InputError, match=r"^a\.json: expected numbers"), expecting("numbers", "a.json"):
        {}["absent"]
