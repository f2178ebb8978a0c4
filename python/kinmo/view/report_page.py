"""The HTML page of a report, from plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

import jinja2

from kinmo._core import __version__
from kinmo.view.training_curves import COLOURS


@dataclass(frozen=True)
class Table:
    """A table of text.

    Attributes:
        caption: Title of the table.
        header: Titles of the columns.
        rows: Cells of each row; the first one names the row. Lines after the first in a cell are small.
        note: Text below the table.
    """

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def is_text(self, column: int) -> bool:
        """True if a cell of the column has a letter in its first line, unlike numbers and times."""
        return any(letter.isalpha() for row in self.rows for letter in row[column].split("\n")[0])


@dataclass(frozen=True)
class Picture:
    """A drawing of a joint or a scan: trusted `svg` markup with a `title` and `lines` of text below it."""

    svg: str
    title: str
    lines: Sequence[str] = ()


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Attributes:
        title: Heading.
        text: Paragraph below it.
        tables: Tables.
        charts: SVGs of `kinmo.view.training_curves`.
        pictures: Pictures.
        more: Tables that are folded away.
        legend: Role and meaning of the axes in the pictures.
        is_folded: The whole section is folded away.
    """

    title: str
    text: str = ""
    tables: Sequence[Table] = ()
    charts: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    more: Sequence[Table] = ()
    legend: Sequence[tuple[str, str]] = ()
    is_folded: bool = False


@dataclass(frozen=True)
class Page:
    """A whole report. `facts` are pairs (name, value) at its head."""

    title: str
    facts: Sequence[tuple[str, str]] = ()
    sections: Sequence[Section] = field(default_factory=tuple)


@cache
def _template() -> jinja2.Template:
    text = resources.files("kinmo.view").joinpath("report_page.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(text)


def render(page: Page) -> str:
    """HTML of a page in one file: styles and pictures inline, no script, nothing fetched."""
    return _template().render(page=page, colours=COLOURS, version=__version__)
