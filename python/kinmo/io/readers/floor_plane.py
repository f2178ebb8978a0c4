"""Floor planes: flat meshes below an object, which scenes have for their pictures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector

MAX_HEIGHT = 0.02
"""Largest height of a floor, relative to its smaller width."""
MIN_WIDTH = 3.0
"""Smallest width of a floor in both directions, relative to that of everything else together."""
MAX_OVERLAP = 0.05
"""Largest height of everything else that may be below the top of a floor, relative to its height."""


def floor_planes(meshes: Mapping[int, Mesh], up: Vector) -> list[int]:
    """Keys of the meshes that are floors, at most all but one.

    Args:
        meshes: Meshes with surfaces, in one frame.
        up: Unit vector [3] along an axis of the frame.
    """
    keys = list(meshes)
    high_axis = int(np.argmax(np.abs(up)))
    across = [axis for axis in range(3) if axis != high_axis]
    corners = [meshes[key].corners * np.where(np.arange(3) == high_axis, np.sign(up[high_axis]), 1.0) for key in keys]
    low, high = np.array([each.min(axis=0) for each in corners]), np.array([each.max(axis=0) for each in corners])
    floors: list[int] = []
    rest = np.arange(len(keys))
    while len(rest) > 1:
        widths = (high - low)[rest][:, across].min(axis=1)
        place = int(np.argmax(widths))
        candidate, others = rest[place], np.delete(rest, place)
        below, above = low[others].min(axis=0), high[others].max(axis=0)
        is_flat = (high - low)[candidate, high_axis] <= MAX_HEIGHT * widths[place]
        is_wide = np.all((high - low)[candidate, across] >= MIN_WIDTH * (above - below)[across])
        is_low = high[candidate, high_axis] <= below[high_axis] + MAX_OVERLAP * (above - below)[high_axis]
        if not (is_flat and is_wide and is_low):
            break
        floors.append(keys[candidate])
        rest = others
    return floors
