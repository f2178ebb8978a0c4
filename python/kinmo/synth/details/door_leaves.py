"""Leaves of doors and windows in the x-y plane: boards and framed panes, centred, with their thickness along z."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.synth.details.appliances import rectangular_frame
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box, sheet


def sash(draw: Draw, width: float, height: float, thickness: float) -> tuple[list[Mesh], list[Mesh]]:
    """A framed pane: the pieces of its frame with glazing bars, and the glass."""
    rim = draw.between(0.04, 0.1) * min(1.5 * width, height)
    half = np.array([width / 2, height / 2, thickness / 2])
    bars = [rectangular_frame(-half, half, rim)] if draw.chance(0.6) else _four_bars(width, height, thickness, rim)
    inner = (width - 2 * rim, height - 2 * rim)
    columns, rows = draw.pick([(1, 1), (1, 2), (2, 2), (2, 3)], [5, 2, 2, 1])
    bar = 0.3 * rim
    bars += [box((bar, inner[1], 0.7 * thickness), (inner[0] * (i / columns - 0.5), 0, 0)) for i in range(1, columns)]
    bars += [box((inner[0], bar, 0.7 * thickness), (0, inner[1] * (i / rows - 0.5), 0)) for i in range(1, rows)]
    glass = sheet(inner, (0, 0, 0), "z") if draw.chance(0.4) else box((*inner, 0.15 * thickness))
    return bars, [glass]


def board(draw: Draw, width: float, height: float, thickness: float) -> list[Mesh]:
    """A door's board: plain, with raised fields, or a sheet without thickness."""
    if draw.chance(0.12):
        return [sheet((width, height), (0, 0, 0), "z")]
    slab = box((width, height, thickness))
    if draw.chance(0.5):
        return [slab]
    rows = draw.integer(1, 3)
    tall = 0.85 * height / rows
    fields = [box((0.7 * width, 0.85 * tall, 1.2 * thickness), (0, tall * (i - (rows - 1) / 2), 0)) for i in range(rows)]
    return [slab, *fields]


def _four_bars(width: float, height: float, thickness: float, rim: float) -> list[Mesh]:
    """A rectangular frame of four separate bars."""
    upright = [box((rim, height, thickness), (s * (width - rim) / 2, 0, 0)) for s in (-1, 1)]
    across = [box((width - 2 * rim, rim, thickness), (0, s * (height - rim) / 2, 0)) for s in (-1, 1)]
    return upright + across
