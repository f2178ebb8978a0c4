"""Tables written as text, JSON, CSV, Markdown and LaTeX, and read from JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.core.errors import InputError
from kinmo.evaluation.tables import (
    TEXT_WIDTH,
    WRITERS,
    Caption,
    Column,
    Table,
    as_latex,
    as_markdown,
    as_text,
    read_table,
    write_table,
)

cells = st.one_of(
    st.none(), st.text(max_size=8), st.integers(-(2**40), 2**40), st.floats(allow_nan=False, allow_infinity=False)
)


NOTES = ("Parts given. " * 12).strip(), "", "Means over joints."
CAPTION = Caption("Table 1", "sample", 3, 4, "test", (0, 1)).noting(*NOTES)
PLAIN = Caption("Table 1", "procedural", 0, 0, "test", (0, 1))
SPECIAL = Table(PLAIN, (Column("a_b & <c>"), Column("x|y", 2)), (("50 % \\ ~^{}$#", 1.005), ("", None)))
"""A table with characters that mean something in Markdown and LaTeX."""
SMALL = Table(CAPTION, (Column("category"), Column("axis", 1)), (("door", 1.0),))


def test_as_text_every_note_starts_a_line_and_no_line_is_too_long() -> None:
    lines = as_text(SMALL).split("\n\n")[0].splitlines()
    assert lines[:2] == ["Table 1.", "sample; 3 shapes, 4 joints; test; seeds 0, 1."]
    assert lines[-1] == "Means over joints."
    assert " ".join(lines[2:-1]) == NOTES[0]
    assert max(map(len, lines)) <= TEXT_WIDTH


def test_in_markdown_only_the_title_is_bold() -> None:
    assert as_markdown(SMALL).startswith("**Table 1.** sample; 3 shapes")


@settings(max_examples=50)
@given(rows=st.lists(st.tuples(st.text(max_size=8), cells), max_size=5), decimals=st.one_of(st.none(), st.integers(0, 4)))
def test_a_written_table_is_read_unchanged(rows: list[tuple[str, float | None]], decimals: int | None) -> None:
    caption = Caption("Table 1", "sample", 3, 4, "test", (0, 1), "note")
    table = Table(caption, (Column("category"), Column("axis", decimals)), tuple(rows))
    with TemporaryDirectory() as folder:
        write_table(table, Path(folder), "t")
        found = read_table(Path(folder) / "t.json")
    assert found == table
    assert all(not isinstance(cell, float) or math.isfinite(cell) for row in found.rows for cell in row)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"title": 1}'])
def test_a_file_without_a_table_raises_an_input_error(text: str, tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(text)
    with pytest.raises(InputError, match=r"t\.json"):
        read_table(tmp_path / "t.json")
    with pytest.raises(InputError):
        read_table(tmp_path / "absent.json")


def test_every_format_holds_every_cell(tmp_path):
    paths = write_table(SPECIAL, tmp_path / "tables", "one")
    assert sorted(path.suffix[1:] for path in paths) == sorted(WRITERS)
    assert len(list((tmp_path / "tables").iterdir())) == len(WRITERS)
    document = json.loads((tmp_path / "tables" / "one.json").read_text())
    assert document["rows"] == [["50 % \\ ~^{}$#", 1.005], ["", None]]
    assert "one.csv" in {path.name for path in paths}
    assert (tmp_path / "tables" / "one.csv").read_text().splitlines()[2] == ","


def test_latex_prints_special_characters_as_they_are():
    text = as_latex(SPECIAL)
    assert r"a\_b \& \textless{}c\textgreater{} & x|y \\" in text
    assert r"50 \% \textbackslash{} \textasciitilde{}\textasciicircum{}\{\}\$\# & " in text
    assert text.count(r"\\") == 3


def test_markdown_cells_keep_their_columns():
    rows = as_markdown(SPECIAL).splitlines()[2:]
    assert all(row.replace("\\|", "").count("|") == 3 for row in rows)


def test_a_row_of_the_wrong_length_raises_an_error():
    with pytest.raises(ValueError, match="rows"):
        Table(CAPTION, (Column("a"),), ((1, 2),))
