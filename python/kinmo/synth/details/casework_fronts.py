"""Fronts of furniture: the openings that they close, their common style, and their panels."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import pull
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import Point, box, extrude, move
from kinmo.synth.synth_object import Node


@dataclass(frozen=True)
class Opening:
    """A rectangular hole in a carcass.

    Attributes:
        x: Horizontal centre.
        y: Vertical centre.
        width: Width.
        height: Height.
        depth: Depth of the space behind it.
        front: Position of the carcass's front along z.
        border: Widths of the carcass's edge to the left and right of the hole, below and above it, that a front which overlaps
            the carcass may cover. None if there is room enough.
    """

    x: float
    y: float
    width: float
    height: float
    depth: float
    front: float
    border: tuple[float, float, float, float] | None = None

    @property
    def low(self) -> float:
        """Lower edge."""
        return self.y - self.height / 2

    @property
    def high(self) -> float:
        """Upper edge."""
        return self.y + self.height / 2


@dataclass(frozen=True)
class Fronts:
    """Common style of the fronts of one piece of furniture.

    Attributes:
        thickness: Thickness of a front.
        gap: Distance from a front to the edge of its opening. It is negative if fronts overlap the carcass.
        reveal: Distance of an overlapping front to the end of the border that it may cover.
        look: "plain", "framed", "raised", "bowed" or "slatted".
        has_handles: True if doors and drawers have handles.
        handle_length: Usual length of a handle.
        grips: Source of the handles if all have one shape; None if each has its own.
        trim: Source of the fittings if all fronts have the same ones; None if each has its own.
    """

    thickness: float
    gap: float
    reveal: float
    look: str
    has_handles: bool
    handle_length: float
    grips: Draw | None = None
    trim: Draw | None = None

    @staticmethod
    def random(draw: Draw, unit: float) -> Fronts:
        """Random style for furniture with boards about `unit` thick."""
        gap = draw.pick([draw.between(0.02, 0.5) * unit, 0.0, -draw.between(0.1, 0.95) * unit, -unit], [4, 2, 2, 3])
        reveal = draw.pick([0.0, draw.between(0.01, 0.3)], [1, 4]) * unit
        look = draw.pick(["plain", "framed", "raised", "bowed", "slatted"], [6, 3, 2, 1, 1])
        thickness, has_handles, length = draw.ratio(0.4, 3.0) * unit, draw.chance(0.65), draw.ratio(0.04, 0.5)
        grips, trim = (draw.identical(1)[0] if draw.chance(0.7) else None for _ in range(2))
        return Fronts(thickness, gap, reveal, look, has_handles, length, grips, trim)

    def back_plane(self, opening: Opening) -> float:
        """Position along z of a front's back: behind the carcass's front if inset, on it if overlapping."""
        return opening.front if self.gap < 0 else opening.front - self.thickness

    def surface(self, opening: Opening) -> float:
        """Position along z of the middle of a front, where its handle stands."""
        return self.back_plane(opening) + self.thickness * {"bowed": 1.6, "framed": 0.9, "raised": 1.35}.get(self.look, 1.0)

    def face(self, opening: Opening) -> Opening:
        """The rectangle that the front of an opening covers."""
        if self.gap >= 0 or opening.border is None:
            return replace(opening, width=opening.width - 2 * self.gap, height=opening.height - 2 * self.gap)
        left, right, below, above = (min(room - self.reveal, -self.gap) for room in opening.border)
        return replace(
            opening,
            x=opening.x + 0.5 * (right - left),
            y=opening.y + 0.5 * (above - below),
            width=opening.width + left + right,
            height=opening.height + below + above,
        )

    def panel(self, draw: Draw, opening: Opening) -> list[Mesh]:
        """Meshes of the front of an opening."""
        face = self.face(opening)
        at = (face.x, face.y, self.back_plane(opening))
        return [move(piece, at) for piece in front_panel(draw, face.width, face.height, self.thickness, self.look)]

    def fit(self, draw: Draw, node: Node, opening: Opening, side: str = "") -> list[Node]:
        """Add fittings to some fronts, below `node`; returns them. `side` is the edge of a door's hinge."""
        face = self.face(opening)
        half, middle = 0.5 * np.array([face.width, face.height]), np.array([face.x, face.y])
        return add_fittings(deepcopy(self.trim) or draw, node, middle - half, middle + half, self.surface(opening), side)

    def grip(self, draw: Draw, length: float, at: Point, opening: Opening, *, vertical: bool) -> list[Mesh]:
        """Meshes of a handle with its foot at `at`; see `pull`."""
        face = self.face(opening)
        return pull(deepcopy(self.grips) or draw, length, at, vertical=vertical, room=min(face.width, face.height))


def front_panel(draw: Draw, width: float, height: float, thickness: float, look: str) -> list[Mesh]:
    """Meshes of a door's or drawer's front, centred, with its back on z = 0."""
    if look == "bowed":
        x = np.linspace(width / 2, -width / 2, 9)
        bow = thickness * draw.between(1.0, 2.5)
        outline = np.stack([x, thickness + bow * (1 - (2 * x / width) ** 2)], axis=1)
        outline = np.concatenate([[[-width / 2, 0.0], [width / 2, 0.0]], outline])[:, ::-1]
        return [extrude(outline, height, "y", capped=True)]
    slab = box((width, height, thickness), (0, 0, thickness / 2))
    if look == "slatted":
        return _slats(draw, width, height, thickness)
    rim = min(0.2 * min(width, height), 2.5 * thickness)
    if look == "plain" or rim <= 0:
        return [slab]
    inner_width, inner_height = width - 2 * rim, height - 2 * rim
    if look == "raised":
        return [slab, box((inner_width, inner_height, 0.4 * thickness), (0, 0, 1.2 * thickness))]
    across = [box((width, rim, thickness), (0, s * (height - rim) / 2, thickness / 2)) for s in (-1, 1)]
    upright = [box((rim, inner_height, thickness), (s * (width - rim) / 2, 0, thickness / 2)) for s in (-1, 1)]
    return [*across, *upright, box((inner_width, inner_height, 0.5 * thickness), (0, 0, 0.35 * thickness))]


def _slats(draw: Draw, width: float, height: float, thickness: float) -> list[Mesh]:
    """Parallel boards, upright or level, that touch each other or are held by two battens behind them."""
    count, upright = draw.integer(3, 10), draw.chance(0.6)
    share = draw.pick([1.0, draw.between(0.7, 0.98)])
    pitch = (width if upright else height) / count
    places = (np.arange(count) + 0.5 - 0.5 * count) * pitch
    size = (share * pitch, height, 0.6 * thickness) if upright else (width, share * pitch, 0.6 * thickness)
    boards = [box(size, (x, 0, 0.7 * thickness) if upright else (0, x, 0.7 * thickness)) for x in places]
    batten = (width, 0.1 * height, 0.4 * thickness) if upright else (0.1 * width, height, 0.4 * thickness)
    ends = [(0, s * 0.35 * height, 0.2 * thickness) if upright else (s * 0.35 * width, 0, 0.2 * thickness) for s in (-1, 1)]
    return boards + [box(batten, at) for at in ends]
