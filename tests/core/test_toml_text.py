"""TOML from unknown sources."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.core.toml_text import MAX_TOML_BYTES, parse_toml

WHERE = Path("some.toml")


def test_a_table_is_read_with_and_without_a_byte_order_mark() -> None:
    for mark in (b"", b"\xef\xbb\xbf"):
        assert parse_toml(mark + b'a = 1\n[b.c]\nd = ["x"]\n', WHERE) == {"a": 1, "b": {"c": {"d": ["x"]}}}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (b"a = " + 100_000 * b"[" + 100_000 * b"]", "nested"),
        (b"a = " + 50 * b"[" + 50 * b"]", "nested"),
        (b"a" + 100_000 * b".a" + b" = 1", "nested"),
        (b"a = " + 10_000 * b"9", "expected TOML"),
        (b"a = \xff", "expected TOML"),
        (b"a = ", "expected TOML"),
        (b"#" * (MAX_TOML_BYTES + 1), "larger than 1 MiB"),
    ],
    ids=["lists", "few lists", "tables", "integer", "bytes", "syntax", "size"],
)
def test_hostile_text_is_an_error_of_one_short_line(text: bytes, problem: str) -> None:
    with pytest.raises(InputError, match=problem) as caught:
        parse_toml(text, WHERE)
    assert len(str(caught.value)) < 700
