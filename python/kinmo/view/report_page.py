"""The page: plain data in, one string of HTML out."""

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
    """A table. Cells are text as it is to be shown; lines after the first are small. `note` stands below it. The first column
    names the row.
    """

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def is_text(self, column: int) -> bool:
        """Whether the first line of a cell of a column has a letter: numbers and times have none."""
        return any(letter.isalpha() for row in self.rows for letter in row[column].split("\n")[0])


@dataclass(frozen=True)
class Picture:
    """A drawing of a joint or a scan: `svg` is trusted markup of `kinmo.view.shape_picture`, `lines` the text below it."""

    svg: str
    title: str
    lines: Sequence[str] = ()


@dataclass(frozen=True)
class Section:
    """A part of the page.

    `charts` are SVGs of `kinmo.view.training_curves`; `more` are tables that are folded away; `legend` explains the roles of the axes
    in the pictures.
    """

    title: str
    text: str = ""
    tables: Sequence[Table] = ()
    charts: Sequence[str] = ()
    pictures: Sequence[Picture] = ()
    more: Sequence[Table] = ()
    legend: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True)
class Page:
    """A whole report. `facts` are the pairs (name, value) at its head."""

    title: str
    facts: Sequence[tuple[str, str]] = ()
    sections: Sequence[Section] = field(default_factory=tuple)


@cache
def _template() -> jinja2.Template:
    text = resources.files("kinmo.view").joinpath("report_page.html.j2").read_text(encoding="utf-8")
    environment = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    return environment.from_string(text)


def render(page: Page) -> str:
    """The HTML of `page`: style and pictures inline, no script, nothing fetched from anywhere."""
    return _template().render(page=page, colours=COLOURS, version=__version__)
