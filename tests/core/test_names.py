"""Names on disk and unique identifiers."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.names import MAX_NAME_BYTES, identifier, name_on_disk, name_or_number, short_name, unique_names


@given(st.lists(st.text() | st.text("é柜%/", min_size=20, max_size=200), unique=True))
def test_every_text_has_its_own_valid_name_on_disk(texts: list[str]) -> None:
    names = [name_on_disk(text) for text in texts]
    assert len(set(names)) == len(names)
    for name in names:
        assert "/" not in name
        assert len(name) <= 200, "prefix, name and ending must fit into 255 bytes"
        assert name.isascii()


def test_only_long_names_are_shortened() -> None:
    assert short_name("a" * MAX_NAME_BYTES, "text") == "a" * MAX_NAME_BYTES
    one, other = (short_name("a" * (MAX_NAME_BYTES + 1), text) for text in ("one", "other"))
    assert one != other
    assert one.startswith("a" * MAX_NAME_BYTES + "~")


def test_names_become_unique_identifiers() -> None:
    assert unique_names(["a b", "a/b", "A_B", "", "<>", "x"]) == ["a_b", "a_b_2", "A_B_3", "part", "part_2", "x"]
    assert unique_names(["3rd-drawer.left", "7"]) == ["part_3rd_drawer_left", "part_7"]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Tür links", "Tur_links"),
        ("Tu\u0308r", "Tur"),
        ("Straße", "Strasse"),
        ("étagère №２", "etagere_No2"),
        ("引き出し箱", ""),
        ("дверь", ""),
        ("ी", ""),
        ("引き出し 2", "2"),
        ("", ""),
    ],
)
def test_identifiers_keep_letters_without_their_accents(name: str, expected: str) -> None:
    assert identifier(name) == expected


@given(st.text(st.characters(codec="ascii")))
def test_identifiers_keep_all_letters_and_digits_of_ascii(text: str) -> None:
    assert [each for each in identifier(text) if each != "_"] == [each for each in text if each.isalnum()]


@given(st.text(), st.integers(0, 99))
def test_a_name_gives_way_to_its_number_if_nothing_is_left_of_it(name: str, number: int) -> None:
    assert name_or_number(name, "body", number) == (name if identifier(name) else f"body_{number}")


@given(st.lists(st.text()))
def test_identifiers_are_valid_and_differ_whatever_the_names(names: list[str]) -> None:
    found = unique_names(names)
    assert all(name.isidentifier() and name.isascii() for name in found)
    assert len({name.lower() for name in found}) == len(names)
