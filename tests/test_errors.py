"""Messages about a user's mistakes."""

from __future__ import annotations

import pytest

from kinmo.errors import did_you_mean
from kinmo.synth.families import family_names


@pytest.mark.parametrize("name, meant", [("refridgerator", "refrigerator"), ("Door", "door_set"), ("LAPTOP", "laptop")])
def test_a_misspelt_name_brings_up_the_nearest(name: str, meant: str) -> None:
    assert did_you_mean(name, family_names()) == f" (did you mean {meant}?)"


def test_a_name_like_none_brings_up_none() -> None:
    assert did_you_mean("xyzzy", family_names()) == "" == did_you_mean("laptop", ())
