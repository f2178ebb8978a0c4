"""Spellings of object categories."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.categories import MAX_CATEGORY_BYTES, canonical_category, same_category


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("door_set", "Door"),
        ("storage_furniture", "StorageFurniture"),
        ("Refrigerator", "refrigerator"),
        ("Trashcan", "trash_can"),
    ],
)
def test_all_spellings_of_a_category_match(one, other):
    assert same_category(one, other)
    assert canonical_category(one) == canonical_category(other)


@pytest.mark.parametrize(
    ("one", "other"), [("garden_gnome", "Door"), ("garden_gnome", "garden"), ("柜子", "椅子"), ("Büro", "Bro"), ("कि", "की")]
)
def test_different_categories_do_not_match(one: str, other: str) -> None:
    assert not same_category(one, other)


@pytest.mark.parametrize("name", ["garden_gnome", "GardenGnome", "Garden gnome", "garden-gnome"])
def test_an_unknown_category_is_spelled_as_in_partnet(name: str) -> None:
    assert canonical_category(name) == "garden_gnome"


@pytest.mark.parametrize(
    ("name", "folder"), [("pots/pans", "pots_pans"), ("../../x", "x"), ("..", "-"), ("a\\b\n", "a_b"), ("柜" * 90, "柜" * 26)]
)
def test_a_category_is_a_valid_folder_name(name: str, folder: str) -> None:
    assert canonical_category(name) == folder


@given(st.text())
def test_the_canonical_spelling_is_stable_and_short(name: str) -> None:
    spelled = canonical_category(name)
    assert canonical_category(spelled) == spelled
    assert same_category(name, spelled)
    assert 0 < len(spelled.encode()) <= MAX_CATEGORY_BYTES
