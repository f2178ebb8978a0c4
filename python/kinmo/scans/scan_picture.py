"""A scan as its camera sees it: points in the colours of their parts, boxes and axes over them (the paper's figure 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind

F64 = NDArray[np.float64]

SIZE = 300
"""Pixels along a side of a picture."""
MARGIN = 0.08
BESIDE = 0.5
"""How far boxes are shown beyond the points: this share of these' extent in the picture, to each side."""
COLOURS = ("#8a8a86", "#3b7dd8", "#d9822b", "#3f9c55", "#8e5bc0", "#c2454e", "#2a9aa5", "#a6882a")
"""Of parts 0 and up, over and over; points of none are pale."""
NO_PART = "#d8d8d4"
EDGES = ((0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7))


@dataclass(frozen=True, eq=False)
class ScanView:
    """What is drawn, all in the camera's frame: K boxes (`centers`, `half_extents` [K, 3], `rotations` [K, 3, 3]) and the axes
    of the joints of parts 1 and up; what is not known is NaN and not drawn.
    """

    points: NDArray[np.floating]
    parts: NDArray[np.integer]
    centers: F64
    rotations: F64
    half_extents: F64
    kinds: tuple[JointKind, ...]
    directions: F64
    pivots: F64


def scan_picture(views: Sequence[ScanView], label: str, size: int = SIZE) -> str:
    """An SVG of one scan, or of several takes on it side by side, all with room for the points of the first and all boxes."""
    frame = _Frame.of(views, size)
    panes = "".join(
        f'<svg x="{size * place}" width="{size}" height="{size}">{_pane(frame, view)}</svg>' for place, view in enumerate(views)
    )
    head = f'<svg class="scan" viewBox="0 0 {size * len(views)} {size}" role="img" aria-label="{escape(label, quote=True)}"'
    return f'{head} xmlns="http://www.w3.org/2000/svg">{panes}</svg>'


def _pane(frame: _Frame, view: ScanView) -> str:
    pieces = [_dots(frame, view.points[view.parts == part], _colour(part)) for part in np.unique(view.parts)]
    for part in range(len(view.centers)):
        if _has_box(view, part):
            pieces.append(_box(frame, view, part))
    for row, kind in enumerate(view.kinds):
        if np.isfinite(view.directions[row]).all():
            pieces.append(_axis(frame, view, row, kind))
    return "".join(pieces)


@dataclass(frozen=True)
class _Frame:
    """From the camera's frame to the picture."""

    scale: float
    shift: tuple[float, float]

    @classmethod
    def of(cls, views: Sequence[ScanView], size: int) -> _Frame:
        points = _on_the_plane(views[0].points)
        low, high = points.min(axis=0), points.max(axis=0)
        beside = BESIDE * float(np.max(high - low))
        corners = [_corners(view, part) for view in views for part in range(len(view.centers)) if _has_box(view, part)]
        boxes = np.clip(_on_the_plane(np.reshape(corners, (-1, 3))), low - beside, high + beside)
        low, high = np.vstack([boxes, low]).min(axis=0), np.vstack([boxes, high]).max(axis=0)
        scale = (1.0 - 2.0 * MARGIN) * size / max(float(np.max(high - low)), 1e-9)
        x, y = (0.5 * size - scale * 0.5 * (low + high)).tolist()
        return cls(scale, (x, y))

    def place(self, points: NDArray[np.floating]) -> F64:
        return np.asarray(_on_the_plane(points) * self.scale + np.array(self.shift), np.float64)


def _on_the_plane(points: NDArray[np.floating]) -> F64:
    """Where points [..., 3] are seen, [..., 2], at a distance of 1."""
    return np.asarray(points[..., :2] / np.maximum(points[..., 2:], 1e-6), np.float64)


def _has_box(view: ScanView, part: int) -> bool:
    return bool(np.isfinite(view.centers[part]).all() and np.isfinite(view.half_extents[part]).all())


def _corners(view: ScanView, part: int) -> F64:
    """Of a box [8, 3]."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    return np.asarray(view.centers[part] + (signs * view.half_extents[part]) @ view.rotations[part].T)


def _colour(part: int) -> str:
    return NO_PART if part < 0 else COLOURS[part % len(COLOURS)]


def _dots(frame: _Frame, points: NDArray[np.floating], colour: str) -> str:
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in frame.place(points))
    return f'<path d="{path}" stroke="{colour}" stroke-width="2.6" stroke-linecap="round" fill="none" opacity="0.75"/>'


def _box(frame: _Frame, view: ScanView, part: int) -> str:
    seen = frame.place(_corners(view, part))
    path = "".join(f"M{seen[a][0]:.1f} {seen[a][1]:.1f}L{seen[b][0]:.1f} {seen[b][1]:.1f}" for a, b in EDGES)
    return f'<path d="{path}" stroke="{_colour(part)}" stroke-width="1.6" fill="none"/>'


def _axis(frame: _Frame, view: ScanView, row: int, kind: JointKind) -> str:
    """A line through the pivot (of a slider, through the middle of its part), as long as its part's box, with a head."""
    part = row + 1
    middle, direction = view.centers[part], view.directions[row]
    if not np.isfinite(middle).all():
        middle = np.median(view.points, axis=0)
    through = middle if kind is JointKind.PRISMATIC else view.pivots[row]
    through = through + (middle - through) @ direction * direction
    half = view.half_extents[part]
    size = half if np.isfinite(half).all() else 0.25 * np.ptp(view.points, axis=0)
    reach = 1.2 * float(np.linalg.norm(size))
    (x0, y0), (x1, y1) = frame.place(np.stack([through - reach * direction, through + reach * direction])).tolist()
    line = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return (
        f'<line {line} stroke="#ffffff" stroke-width="5"/><line {line} stroke="#111111" stroke-width="2.2"/>'
        f'<circle cx="{x1:.1f}" cy="{y1:.1f}" r="4" fill="#111111"/>'
    )
