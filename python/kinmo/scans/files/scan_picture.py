"""SVG picture of a scan in the camera's view: points in part colours, amodal boxes and joint axes (the paper's figure 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind

F64 = NDArray[np.float64]

SIZE = 300
"""Side of a view, pixels."""
MARGIN = 0.08
"""Empty border, as a share of the side."""
BOX_MARGIN = 0.5
"""Largest room for boxes beyond the points on each side, as a share of the points' extent."""
COLOURS = ("#8a8a86", "#3b7dd8", "#d9822b", "#3f9c55", "#8e5bc0", "#c2454e", "#2a9aa5", "#a6882a")
"""Colours of parts 0 and up, repeated as needed."""
NO_PART_COLOUR = "#d8d8d4"
EDGES = ((0, 1), (0, 2), (0, 4), (1, 3), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 6), (5, 7), (6, 7))
"""Edges of a box as pairs of its corners (`_corners`)."""


@dataclass(frozen=True, eq=False)
class ScanView:
    """Contents of one picture, in the camera frame; NaN entries are unknown and not drawn.

    Attributes:
        points: Points [n, 3].
        parts: Part [n] of each point; below 0: none.
        centers: Centers [K, 3] of the boxes.
        rotations: Axes of the boxes as columns [K, 3, 3].
        half_extents: Half sides [K, 3] of the boxes.
        kinds: Joint kinds [K - 1] of parts 1 and up.
        directions: Unit directions [K - 1, 3] of the joint axes.
        pivots: Points [K - 1, 3] on the joint axes.
    """

    points: NDArray[np.floating]
    parts: NDArray[np.integer]
    centers: F64
    rotations: F64
    half_extents: F64
    kinds: tuple[JointKind, ...]
    directions: F64
    pivots: F64


def scan_picture(views: Sequence[ScanView], label: str) -> str:
    """SVG picture of views of one scan side by side, such as prediction and truth, with an accessible description.

    The points of the first view and the boxes of all set the scale.
    """
    frame = _Frame.of(views)
    panes = "".join(
        f'<svg x="{SIZE * place}" width="{SIZE}" height="{SIZE}">{_pane(frame, view)}</svg>' for place, view in enumerate(views)
    )
    head = f'<svg class="scan" viewBox="0 0 {SIZE * len(views)} {SIZE}" role="img" aria-label="{escape(label, quote=True)}"'
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
    """Mapping from the camera frame to the picture."""

    scale: float
    shift: tuple[float, float]

    @classmethod
    def of(cls, views: Sequence[ScanView]) -> _Frame:
        points = _projected(views[0].points)
        low, high = points.min(axis=0), points.max(axis=0)
        room = BOX_MARGIN * float(np.max(high - low))
        corners = [_corners(view, part) for view in views for part in range(len(view.centers)) if _has_box(view, part)]
        boxes = np.clip(_projected(np.reshape(corners, (-1, 3))), low - room, high + room)
        low, high = np.vstack([boxes, low]).min(axis=0), np.vstack([boxes, high]).max(axis=0)
        scale = (1.0 - 2.0 * MARGIN) * SIZE / max(float(np.max(high - low)), 1e-9)
        x, y = (0.5 * SIZE - scale * 0.5 * (low + high)).tolist()
        return cls(scale, (x, y))

    def map(self, points: NDArray[np.floating]) -> F64:
        return np.asarray(_projected(points) * self.scale + np.array(self.shift), np.float64)


def _projected(points: NDArray[np.floating]) -> F64:
    """Projection [..., 2] of points [..., 3] to the plane at distance 1."""
    return np.asarray(points[..., :2] / np.maximum(points[..., 2:], 1e-6), np.float64)


def _has_box(view: ScanView, part: int) -> bool:
    return bool(np.isfinite(view.centers[part]).all() and np.isfinite(view.half_extents[part]).all())


def _corners(view: ScanView, part: int) -> F64:
    """Corners [8, 3] of a part's box."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    return np.asarray(view.centers[part] + (signs * view.half_extents[part]) @ view.rotations[part].T)


def _colour(part: int) -> str:
    return NO_PART_COLOUR if part < 0 else COLOURS[part % len(COLOURS)]


def _dots(frame: _Frame, points: NDArray[np.floating], colour: str) -> str:
    path = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in frame.map(points))
    return f'<path d="{path}" stroke="{colour}" stroke-width="2.6" stroke-linecap="round" fill="none" opacity="0.75"/>'


def _box(frame: _Frame, view: ScanView, part: int) -> str:
    seen = frame.map(_corners(view, part))
    path = "".join(f"M{seen[a][0]:.1f} {seen[a][1]:.1f}L{seen[b][0]:.1f} {seen[b][1]:.1f}" for a, b in EDGES)
    return f'<path d="{path}" stroke="{_colour(part)}" stroke-width="1.6" fill="none"/>'


def _axis(frame: _Frame, view: ScanView, row: int, kind: JointKind) -> str:
    """Line with a head through the pivot (of a slider: through the middle of its part), as long as the part's box."""
    part = row + 1
    middle, direction = view.centers[part], view.directions[row]
    if not np.isfinite(middle).all():
        middle = np.median(view.points, axis=0)
    through = middle if kind is JointKind.PRISMATIC else view.pivots[row]
    through = through + (middle - through) @ direction * direction
    half = view.half_extents[part]
    size = half if np.isfinite(half).all() else 0.25 * np.ptp(view.points, axis=0)
    reach = 1.2 * float(np.linalg.norm(size))
    (x0, y0), (x1, y1) = frame.map(np.stack([through - reach * direction, through + reach * direction])).tolist()
    line = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return (
        f'<line {line} stroke="#ffffff" stroke-width="5"/><line {line} stroke="#111111" stroke-width="2.2"/>'
        f'<circle cx="{x1:.1f}" cy="{y1:.1f}" r="4" fill="#111111"/>'
    )
