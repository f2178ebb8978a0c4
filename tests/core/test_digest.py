"""Hashes of plain data."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.digest import digest

words = st.text(max_size=5)
scalars = st.none() | st.booleans() | st.integers() | words
plain_data = scalars | st.lists(scalars, max_size=3) | st.dictionaries(words, scalars, max_size=3)


@given(st.dictionaries(words, plain_data, min_size=1, max_size=4))
def test_a_digest_does_not_depend_on_the_order_of_keys(value: dict[str, Any]) -> None:
    assert digest(value) == digest(dict(reversed(value.items())))
    assert digest(value) != digest({**value, "one more key": 1})
