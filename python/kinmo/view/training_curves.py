"""Training curves as inline SVG that takes its colours from the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

WIDTH = 340
"""Width of a chart. All lengths are in units of the SVG."""
PLOT = 136  # height of the area between the axes
LETTER, GAP, ROW = 5.4, 12, 13  # width of a letter in the key (roughly), space between two names, and height of a row
LEFT, RIGHT, TITLE, BOTTOM = 46, 14, 15, 28
"""Margins around the area between the axes; the key stands between it and the title."""
COLOURS = 10  # number of colours of lines; the page defines them

Points = Sequence[tuple[float, float]]


def line_chart(title: str, series: Mapping[str, Points], x_label: str) -> str:
    """SVG of lines on one pair of linear axes, from points (x, y) by name of the line; empty if no series has a point.

    Points that are not finite are skipped.
    """
    drawn = {name: [(x, y) for x, y in points if math.isfinite(x) and math.isfinite(y)] for name, points in series.items()}
    drawn = {name: points for name, points in drawn.items() if points}
    if not drawn:
        return ""
    xs = [x for points in drawn.values() for x, _ in points]
    ys = [y for points in drawn.values() for _, y in points]
    across, upward = _ticks(min(xs), max(xs)), _ticks(min(ys), max(ys))
    key = _key(list(drawn))
    top = TITLE + key[-1][1] + 8
    height = top + PLOT + BOTTOM

    def place(x: float, y: float) -> str:
        u = LEFT + (x - across[0]) / (across[-1] - across[0]) * (WIDTH - LEFT - RIGHT)
        v = top + PLOT - (y - upward[0]) / (upward[-1] - upward[0]) * PLOT
        return f"{u:.1f},{v:.1f}"

    pieces = [f'<text class="title" x="2" y="{TITLE - 2}">{escape(title)}</text>']
    for y in upward:
        u, v = place(across[0], y).split(",")
        pieces.append(f'<line class="grid" x1="{u}" x2="{WIDTH - RIGHT}" y1="{v}" y2="{v}"/>')
        pieces.append(f'<text class="tick" text-anchor="end" x="{float(u) - 4:.1f}" y="{float(v) + 3:.1f}">{y:g}</text>')
    for x in across:
        u, _ = place(x, upward[0]).split(",")
        pieces.append(f'<text class="tick" text-anchor="middle" x="{u}" y="{height - BOTTOM + 13}">{x:g}</text>')
    pieces.append(f'<text class="tick" text-anchor="end" x="{WIDTH - RIGHT}" y="{height - 3}">{escape(x_label)}</text>')
    for index, ((name, points), (left, below)) in enumerate(zip(drawn.items(), key, strict=True)):
        path = " ".join(place(x, y) for x, y in (points if len(points) > 1 else points * 2))  # one point is a dot
        pieces.append(f'<polyline class="series s{index % COLOURS}" points="{path}"/>')
        pieces.append(f'<text class="key s{index % COLOURS}" x="{left:.0f}" y="{TITLE + below}">{escape(name)}</text>')
    head = f'<svg class="chart" viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{escape(title, quote=True)}">'
    return f"{head}{''.join(pieces)}</svg>"


def _key(names: Sequence[str]) -> list[tuple[float, int]]:
    """Positions of the names in the key: x, and y below the title. A name that does not fit begins another row."""
    places = []
    x, y = float(LEFT), ROW
    for name in names:
        if x > LEFT and x + LETTER * len(name) > WIDTH:
            x, y = float(LEFT), y + ROW
        places.append((x, y))
        x += LETTER * len(name) + GAP
    return places


def _ticks(low: float, high: float, about: int = 4) -> list[float]:
    """Evenly spaced round numbers that cover the range from `low` to `high`, at least two."""
    if high - low < 1e-6 * max(abs(low), abs(high)) or high == low:
        high = low + (0.5 * abs(low) or 1.0)
    raw = (high - low) / about
    unit = 10.0 ** math.floor(math.log10(raw))
    step = next(unit * factor for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if unit * factor >= raw * 0.999)
    first = math.floor(low / step + 1e-9)
    last = math.ceil(high / step - 1e-9)
    return [index * step for index in range(first, last + 1)]
