"""Tables as text, and back from their JSON as they were."""

from __future__ import annotations

import math
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.evaluation.tables import TEXT_WIDTH, Caption, Column, Table, as_markdown, as_text, read_table, write_table

cells = st.one_of(
    st.none(), st.text(max_size=8), st.integers(-(2**40), 2**40), st.floats(allow_nan=False, allow_infinity=False)
)


NOTES = ("Parts given. " * 12).strip(), "", "Means over joints."
CAPTION = Caption("Table 1", "sample", 3, 4, "test", (0, 1)).noting(*NOTES)
SMALL = Table(CAPTION, (Column("category"), Column("axis", 1)), (("door", 1.0),))


def test_in_a_terminal_every_note_of_a_caption_begins_a_line_and_none_is_too_long() -> None:
    lines = as_text(SMALL).split("\n\n")[0].splitlines()
    assert lines[:2] == ["Table 1.", "sample; 3 shapes, 4 joints; test; seeds 0, 1."]
    assert lines[-1] == "Means over joints."
    assert " ".join(lines[2:-1]) == NOTES[0]
    assert max(map(len, lines)) <= TEXT_WIDTH


def test_in_markdown_the_title_alone_is_bold() -> None:
    assert as_markdown(SMALL).startswith("**Table 1.** sample; 3 shapes")


@settings(max_examples=50)
@given(rows=st.lists(st.tuples(st.text(max_size=8), cells), max_size=5), decimals=st.one_of(st.none(), st.integers(0, 4)))
def test_a_written_table_is_read_as_it_was(rows: list[tuple[str, float | None]], decimals: int | None) -> None:
    caption = Caption("Table 1", "sample", 3, 4, "test", (0, 1), "note")
    table = Table(caption, (Column("category"), Column("axis", decimals)), tuple(rows))
    with TemporaryDirectory() as folder:
        write_table(table, Path(folder), "t")
        found = read_table(Path(folder) / "t.json")
    assert found == table
    assert all(not isinstance(cell, float) or math.isfinite(cell) for row in found.rows for cell in row)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"title": 1}'])
def test_what_is_no_table_is_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(text)
    with pytest.raises(InputError, match=r"t\.json"):
        read_table(tmp_path / "t.json")
    with pytest.raises(InputError):
        read_table(tmp_path / "absent.json")
