"""The up direction by names of parts, such as "carcass_top" and "foot", for files that do not state it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from kinmo.core.frames import Axis
from kinmo.core.name_words import words_of
from kinmo.core.shape import Mesh, bounds_of

HIGH = frozenset({"top", "upper", "roof", "ceiling", "countertop", "worktop"})
"""Words for parts that are high."""
LOW = frozenset({"bottom", "lower", "foot", "feet", "leg", "legs", "wheel", "wheels", "caster", "castor", "plinth", "pedestal"})
"""Words for parts that are low."""
MIN_RISE = 0.15
"""Least mean height of high parts above the middle, and of low ones below it, as a share of the object's extent."""
CLEARLY = 2.0
"""Factor by which one axis must tell high parts from low ones better than the other."""


def up_by_names(named: Iterable[tuple[str, Mesh]]) -> Axis | None:
    """The axis, y or z, along which parts with names of high parts lie high, and those of low ones low.

    Args:
        named: Names and meshes of parts, in one frame.

    Returns:
        The axis. None if no name tells it, or names contradict each other.
    """
    parts = [(set(words_of(name)), mesh) for name, mesh in named if len(mesh.faces)]
    if not parts:
        return None
    low, high = bounds_of(mesh for _, mesh in parts)
    heights = [
        (1.0 if words & HIGH else -1.0) * (0.5 * (mesh.corners.min(axis=0) + mesh.corners.max(axis=0)) - 0.5 * (low + high))
        for words, mesh in parts
        if bool(words & HIGH) != bool(words & LOW)
    ]
    if not heights:
        return None
    rise = np.mean(heights, axis=0) / np.maximum(high - low, np.finfo(float).tiny)
    y, z = float(rise[1]), float(rise[2])
    if max(y, z) < MIN_RISE or max(y, z) < CLEARLY * min(y, z):
        return None
    return "z" if z > y else "y"
