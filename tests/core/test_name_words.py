"""Words of the names of parts."""

from __future__ import annotations

import pytest

from kinmo.core.name_words import tell_apart, words_of


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Left_Door.001", ["left", "door"]),
        ("引き出し2", ["引き出し"]),
        ("part_3", ["part"]),
        ("12", []),
        ("Tür-Griff", ["tür", "griff"]),
    ],
)
def test_words_are_runs_of_letters_of_any_script(name: str, words: list[str]) -> None:
    assert words_of(name) == words


def test_names_that_differ_in_digits_alone_tell_nothing_apart() -> None:
    assert not tell_apart(["Cube.001", "Cube.002", ""])
    assert not tell_apart(["door"])
    assert tell_apart(["door", "Cube.001"])
