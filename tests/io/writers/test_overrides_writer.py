"""overrides.toml as kinmo writes it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.toml_text import parse_toml
from kinmo.io.writers.overrides_writer import overrides_text

NAMES = st.text(st.characters(exclude_categories=("Cs",)), max_size=8)
VALUES = st.one_of(st.booleans(), st.integers(-(2**53), 2**53), st.floats(allow_nan=False, allow_infinity=False), NAMES)
TABLES = st.dictionaries(NAMES, st.dictionaries(NAMES, VALUES | st.lists(VALUES, max_size=3), max_size=4), max_size=3)


@given(TABLES)
def test_bodies_of_any_name_are_read_back(bodies: dict[str, Any]) -> None:
    text = overrides_text({"bodies": bodies})
    assert parse_toml(text.encode(), Path("overrides.toml")) == {"bodies": bodies}


def test_no_corrections_are_an_empty_file() -> None:
    assert overrides_text({}) == ""
