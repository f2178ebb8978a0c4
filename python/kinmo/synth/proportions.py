"""Proportions: whole objects are stretched along x, y and z, as far as their joints stay true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.synth.draw import Draw
from kinmo.synth.primitives.transforms import scale
from kinmo.synth.synth_object import Link, SynthObject

STRETCHED_SHARE = 0.5
"""Share of objects that are stretched."""
MAX_STRETCH = 1.6
"""Largest factor of one axis. The smallest one is its inverse."""
SQUARE_SHARE = 0.9
"""Share of the surface with normals along x, y or z from which a part counts as square."""
ROUND_REACH = 0.3
"""Distance of a part's centre from its axis up to which the part turns about itself, as a fraction of its size across."""


def stretch_object(obj: SynthObject, draw: Draw) -> None:
    """Stretch an object and its joints by one factor per axis, in place. Call it before `SynthObject.apply_rest_pose`.

    Two axes get the same factor if a part turns in their plane, unless that part is square and hinged at its edge, like a door.
    """
    if not draw.chance(STRETCHED_SHARE):
        return
    group = np.arange(3)
    for link in obj.links:
        for one, other in _tied_axes(obj, link):
            group[group == group[other]] = group[one]
    drawn = [draw.ratio(1.0 / MAX_STRETCH, MAX_STRETCH) for _ in range(3)]
    factors = np.array([drawn[index] for index in group])
    for leaf in obj.root.leaves():
        leaf.pieces = [scale(piece, factors) for piece in leaf.pieces]
    for link in obj.links:
        if link.motion is not None:
            # Directions are along an axis, or all factors are equal: both keep them.
            link.motion = replace(link.motion.scaled(factors), direction=link.motion.direction)


def _tied_axes(obj: SynthObject, link: Link) -> list[tuple[int, int]]:
    """Pairs of axes that need the same factor for the joint of a link."""
    motion = link.motion
    if motion is None:
        return []
    unit = np.abs(motion.direction) / np.linalg.norm(motion.direction)
    along = int(np.argmax(unit))
    if unit[along] < 1.0 - 1e-9:
        return [(0, 1), (1, 2)]
    across = [axis for axis in range(3) if axis != along]
    if not motion.has_position:
        return []
    pieces = [piece for carried in obj.subtree(link) for leaf in carried.leaves() for piece in leaf.pieces]
    vertices = np.concatenate([piece.vertices for piece in pieces])
    low, high = vertices.min(axis=0)[across], vertices.max(axis=0)[across]
    off_centre = np.linalg.norm(0.5 * (low + high) - motion.origin[across])
    turns_about_itself = motion.no_limit or motion.rotates or off_centre < ROUND_REACH * np.linalg.norm(high - low)
    normals = np.concatenate([np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]) for t in (piece.triangles for piece in pieces)])
    lengths = np.linalg.norm(normals, axis=1)
    is_square = lengths[np.abs(normals).max(axis=1) > 0.999 * lengths].sum() > SQUARE_SHARE * lengths.sum()
    return [] if is_square and not turns_about_itself else [(across[0], across[1])]
