"""Tables of results, written as text, JSON, CSV, Markdown and LaTeX."""

from __future__ import annotations

import csv
import io
import json
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.evaluation.aggregate import Estimate
from kinmo.io.atomic_files import write_text_atomically

Cell = str | float | int | None
"""Content of a cell. None is a missing figure: it is printed as a dash, and no mean counts it."""

DASH = "–"

TEXT_WIDTH = 100
"""Largest width of a caption in a terminal, in characters. Tables may be wider."""


@dataclass(frozen=True)
class Caption:
    """The facts that a table needs to be understood. Tables of scans count test `scans`, others true `joints`."""

    title: str
    data: str
    shapes: int
    joints: int
    split: str
    seeds: tuple[int, ...]
    note: str = ""
    scans: int = 0

    def __str__(self) -> str:
        return f"{self.title}. {self.facts}"

    def noting(self, *notes: str) -> Caption:
        """The caption with more lines in its note, one for each note that is not empty."""
        return replace(self, note="\n".join(filter(None, [self.note, *notes])))

    @property
    def facts(self) -> str:
        """Everything but the title."""
        seeds = ", ".join(map(str, self.seeds)) or "none"
        counts = counted(self.scans, "test scan") if self.scans else counted(self.joints, "joint")
        facts = f"{self.data}; {counted(self.shapes, 'shape')}, {counts}; {self.split}; seeds {seeds}."
        return "\n".join(filter(None, [facts, self.note]))


@dataclass(frozen=True)
class Column:
    """A column of numbers with `decimals` digits after the point, or of words if `decimals` is None."""

    title: str
    decimals: int | None = None

    def text(self, cell: Cell) -> str:
        """The printed text of a cell."""
        if cell is None:
            return DASH
        return f"{cell:.{self.decimals}f}" if isinstance(cell, float) and self.decimals is not None else str(cell)

    def interval(self, value: Cell | Estimate) -> str | None:
        """The printed interval of an estimate; None for other values."""
        return f"{value.low:.{self.decimals}f} to {value.high:.{self.decimals}f}" if isinstance(value, Estimate) else None


INTERVAL = Column("95 %")  # column of the 95 % intervals of the figures in the column before

Values = Mapping[str, Cell | Estimate]
"""Values of a row by title of the column. Those that it lacks are missing figures."""


@dataclass(frozen=True)
class Table:
    """A table: a caption, columns, and rows with one cell a column."""

    caption: Caption
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def __post_init__(self) -> None:
        if any(len(row) != len(self.columns) for row in self.rows):
            raise ValueError("rows: expected one cell a column in every row")

    @classmethod
    def of(cls, caption: Caption, columns: Iterable[Column], rows: Iterable[Values]) -> Table:
        """A table of values by title of the column. An `INTERVAL` shows that of the estimate in the column before."""
        columns = tuple(columns)
        return cls(caption, columns, tuple(tuple(_cells(columns, row)) for row in rows))

    def cells(self) -> list[list[str]]:
        """Printed text of all cells by row, the head first."""
        body = [[column.text(cell) for column, cell in zip(self.columns, row, strict=True)] for row in self.rows]
        return [[column.title for column in self.columns], *body]


def _cells(columns: Sequence[Column], row: Values) -> Iterator[Cell]:
    values = [row.get(column.title) for column in columns]
    for place, (column, value) in enumerate(zip(columns, values, strict=True)):
        if column == INTERVAL:
            yield columns[place - 1].interval(values[place - 1])
        else:
            yield value.value if isinstance(value, Estimate) else value


def as_text(table: Table) -> str:
    """A table for a terminal, in aligned columns: words to the left, numbers to the right."""
    cells = table.cells()
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]

    def line(row: Sequence[str]) -> str:
        padded = (
            text.ljust(width) if column.decimals is None else text.rjust(width)
            for text, width, column in zip(row, widths, table.columns, strict=True)
        )
        return "  ".join(padded).rstrip()

    rule = "-" * (sum(widths) + 2 * (len(widths) - 1))
    facts = [part for text in table.caption.facts.splitlines() for part in textwrap.wrap(text, TEXT_WIDTH)]
    return "\n".join([f"{table.caption.title}.", *facts, "", line(cells[0]), rule, *map(line, cells[1:]), ""])


def as_json(table: Table) -> str:
    """Caption, columns and rows as JSON with full precision, to be read by `read_table`. Missing figures are null."""
    columns = {"columns": [column.title for column in table.columns], "decimals": [column.decimals for column in table.columns]}
    document = {**asdict(table.caption), **columns, "rows": table.rows}
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_table(path: Path) -> Table:
    """Read a JSON file of `as_json`. Raises InputError if it cannot be read or has another form."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        caption = {key: data[key] for key in ("title", "data", "shapes", "joints", "split", "note", "scans")}
        columns = tuple(map(Column, data["columns"], data["decimals"]))
        return Table(Caption(**caption, seeds=tuple(data["seeds"])), columns, tuple(map(tuple, data["rows"])))
    except OSError as error:
        raise InputError(path, f"expected a table ({error.strerror})") from error
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(path, f"expected a table ({error})") from error


def as_csv(table: Table) -> str:
    """Head and rows as CSV with full precision, without the caption. Missing figures are empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([column.title for column in table.columns])
    writer.writerows(["" if cell is None else cell for cell in row] for row in table.rows)
    return text.getvalue()


def as_markdown(table: Table) -> str:
    """A table in GitHub's Markdown, below its caption."""
    head, *body = ([cell.replace("\\", "\\\\").replace("|", "\\|").replace("\n", " ") for cell in row] for row in table.cells())
    rule = [":--" if column.decimals is None else "--:" for column in table.columns]
    lines = ["| " + " | ".join(row) + " |" for row in (head, rule, *body)]
    return "\n".join([f"**{table.caption.title}.** {table.caption.facts}", "", *lines, ""])


_LATEX = {character: f"\\{character}" for character in "&%$#_{}"} | {"<": r"\textless{}", ">": r"\textgreater{}", DASH: "--"}
_LATEX |= {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_ESCAPES = str.maketrans(_LATEX)  # special characters of LaTeX, escaped


def as_latex(table: Table) -> str:
    """A LaTeX table environment with rules of the package booktabs."""
    head, *body = ([cell.translate(_ESCAPES) for cell in row] for row in table.cells())
    layout = "".join("l" if column.decimals is None else "r" for column in table.columns)
    return "\n".join(
        [
            r"\begin{table}",
            r"\centering",
            rf"\caption{{{str(table.caption).translate(_ESCAPES)}}}",
            rf"\begin{{tabular}}{{{layout}}}",
            r"\toprule",
            " & ".join(head) + r" \\",
            r"\midrule",
            *(" & ".join(row) + r" \\" for row in body),
            r"\bottomrule",
            r"\end{tabular}",
            r"\end{table}",
            "",
        ]
    )


WRITERS: dict[str, Callable[[Table], str]] = {
    "txt": as_text,
    "json": as_json,
    "csv": as_csv,
    "md": as_markdown,
    "tex": as_latex,
}
"""Writers by the ending of the file."""


def write_table(table: Table, folder: Path, name: str) -> list[Path]:
    """Write a table to `folder`/`name`.txt, .json, .csv, .md and .tex. Returns the five paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for ending, write in WRITERS.items():
        paths.append(folder / f"{name}.{ending}")
        write_text_atomically(paths[-1], write(table))
    return paths
