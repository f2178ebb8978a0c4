"""The HTML page of a report, from plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

import jinja2

from kinmo._core import __version__
from kinmo.evaluation.tables import DASH, INTERVAL
from kinmo.evaluation.tables import Table as FigureTable
from kinmo.view.static_page import viewer_script, viewer_style
from kinmo.view.training_curves import COLOURS


@dataclass(frozen=True)
class Table:
    """A table of text with a note below it. The first cell of a row names it. Lines after the first in a cell are small."""

    caption: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    @classmethod
    def of(cls, figures: FigureTable) -> Table:
        """A table of figures with its facts below, and with intervals below their figures."""
        titles, *rows = figures.cells()
        for place in reversed(range(len(titles))):
            if figures.columns[place] == INTERVAL:
                for cells in (titles, *rows):
                    interval = cells.pop(place)
                    cells[place - 1] += "" if interval == DASH else f"\n{interval}"
        return cls(figures.caption.title, titles, rows, figures.caption.facts)

    def is_text(self, column: int) -> bool:
        """True if a cell of the column has a letter in its first line, unlike numbers and times."""
        return any(letter.isalpha() for row in self.rows for letter in row[column].split("\n")[0])


@dataclass(frozen=True)
class Picture:
    """A drawing of a joint or a scan: trusted `svg` markup with a `title` and `lines` of text below it.

    With a `scene` (JSON by `kinmo.view.scene_data`), the page can show the object in 3D.
    """

    svg: str
    title: str
    lines: Sequence[str] = ()
    scene: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the page: a heading, a paragraph of text, and contents. It may be folded away as a whole.

    Charts are SVGs of `kinmo.view.training_curves`. `more` tables are folded away. The legend has the role and the meaning of
    the axes in the pictures.
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
    """HTML of a page in one file: styles and pictures inline, nothing fetched. It has a script if it shows objects in 3D."""
    viewer = {"script": viewer_script(), "style": viewer_style()} if any(_scenes(page)) else None
    return _template().render(page=page, colours=COLOURS, version=__version__, viewer=viewer)


def _scenes(page: Page) -> Iterator[str]:
    return (picture.scene for section in page.sections for picture in section.pictures if picture.scene)
