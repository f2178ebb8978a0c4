"""Charts: every point inside the frame, nothing drawn that is not a number."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.view.training_curves import LETTER, WIDTH, line_chart

values = st.floats(-1e12, 1e12, allow_nan=False)


@settings(max_examples=100)
@given(st.lists(st.tuples(values, values), min_size=1, max_size=20))
def test_all_points_lie_inside_the_chart(points: list[tuple[float, float]]) -> None:
    svg = ElementTree.fromstring(line_chart("loss", {"training": points}, "epoch"))
    line = svg.find("polyline")
    assert line is not None
    for pair in line.attrib["points"].split():
        x, y = map(float, pair.split(","))
        assert 0 <= x <= WIDTH and 0 <= y <= float(svg.attrib["viewBox"].split()[3])


@given(st.lists(st.text("abcdefgh ", min_size=1, max_size=30), min_size=1, max_size=8, unique=True))
def test_the_names_of_all_series_lie_inside_the_chart_and_apart(names: list[str]) -> None:
    svg = ElementTree.fromstring(line_chart("errors", {name: [(0, 1.0), (1, 2.0)] for name in names}, "epoch"))
    keys = [text for text in svg.iter("text") if text.attrib["class"].startswith("key")]
    assert len(keys) == len(names)
    spans = [(float(k.attrib["y"]), float(k.attrib["x"]), float(k.attrib["x"]) + LETTER * len(k.text or "")) for k in keys]
    assert all(end <= WIDTH for _, _, end in spans)
    for one, other in zip(sorted(spans), sorted(spans)[1:], strict=False):
        assert one[0] < other[0] or one[2] < other[1]
    highest = min(float(pair.split(",")[1]) for line in svg.iter("polyline") for pair in line.attrib["points"].split())
    assert max(y for y, _, _ in spans) < highest


def test_values_that_are_no_numbers_are_left_out() -> None:
    chart = line_chart("loss", {"a": [(0, math.nan), (1, 2.0), (2, math.inf), (3, 4.0)], "b": [(0, math.nan)]}, "epoch")
    assert chart.count("<polyline") == 1
    assert "nan" not in chart and "inf" not in chart


def test_nothing_to_draw_is_no_chart() -> None:
    assert line_chart("loss", {"a": []}, "epoch") == ""


def test_larger_values_stand_higher() -> None:
    svg = ElementTree.fromstring(line_chart("accuracy", {"a": [(0, 1.0), (1, 3.0)]}, "epoch"))
    line = svg.find("polyline")
    assert line is not None
    (x0, y0), (x1, y1) = (map(float, pair.split(",")) for pair in line.attrib["points"].split())
    assert x1 > x0 and y1 < y0
