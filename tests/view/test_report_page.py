"""The page: self-contained, escaped, and without a complaint from a browser."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from browser import assert_shown_without_complaint, needs_browser

from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Mesh
from kinmo.evaluation.tables import INTERVAL, Caption, Column
from kinmo.evaluation.tables import Table as FigureTable
from kinmo.view.report_page import Page, Picture, Section, Table, render
from kinmo.view.shape_picture import Axis, object_picture
from kinmo.view.training_curves import line_chart

TRICKY = "<script>alert('&')</script>"


def page() -> Page:
    triangle = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]], np.uint32))
    hinge = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3))
    svg = object_picture((triangle,), frozenset({0}), (Axis(hinge, "truth"),), np.array([0.0, 1.0, 0.0]), TRICKY)
    return Page(
        TRICKY,
        [("workspace", TRICKY)],
        [
            Section("Table 1", TRICKY, [Table(TRICKY, ["category", "angle"], [["door", "1.0°"]], TRICKY)]),
            Section("Training", charts=[line_chart("loss", {"training": [(0, 1.0), (1, 0.5)]}, "epoch")]),
            Section("Pictures", pictures=[Picture(svg, "100015", [TRICKY])], legend=[("truth", TRICKY)]),
            Section("More", more=[Table("c", ["a"], [[TRICKY]])]),
        ],
    )


class Links(HTMLParser):
    """Collects what a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.fetched: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.fetched += [value or "" for name, value in attrs if name in ("href", "src", "srcset", "xlink:href", "data")]


def test_the_page_fetches_nothing() -> None:
    html = render(page())
    links = Links()
    links.feed(html)
    assert links.fetched
    assert all(link.startswith(("data:", "#")) for link in links.fetched)
    assert not re.search(r"@import|url\(|<script", html)


def test_text_is_escaped_everywhere() -> None:
    assert TRICKY not in render(page())


@needs_browser
@pytest.mark.parametrize("width", [400, 1200])
def test_a_browser_shows_it_without_errors_and_without_scrolling_sideways(tmp_path: Path, width: int) -> None:
    assert_shown_without_complaint(render(page()), width, tmp_path)


def test_columns_of_words_and_of_numbers_are_told_apart() -> None:
    rows = [("a", "240 shapes below x", "0.02..0.35", "–"), ("b", "8 rows", "–", "–")]
    table = Table("", ("name", "what", "interval", "nothing"), rows)
    assert [table.is_text(column) for column in range(4)] == [True, True, False, False]


def test_intervals_stand_below_their_figures_and_facts_below_the_table() -> None:
    caption = Caption("Table 2", "sample", 3, 4, "test", (0, 1), "a note")
    columns = (Column("trained on"), Column("rotation", 1), INTERVAL, Column("axis", 1), INTERVAL)
    rows = (("some", 21.44, "16 to 27", 0.4, "0.2 to 0.7"), ("authors' data", 8.0, None, None, None))
    found = Table.of(FigureTable(caption, columns, rows))
    assert found.caption == "Table 2"
    assert found.note == "sample; 3 shapes, 4 joints; test; seeds 0, 1.\na note"
    assert found.header == ["trained on", "rotation\n95 %", "axis\n95 %"]
    assert found.rows == [["some", "21.4\n16 to 27", "0.4\n0.2 to 0.7"], ["authors' data", "8.0", "–"]]
    assert [found.is_text(column) for column in range(3)] == [True, False, False]
