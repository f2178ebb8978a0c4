"""Short words for a joint, such as "hinge, vertical, left edge", by which people tell ranked joints apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinmo.core.joint import KIND_WORDS, Joint
from kinmo.core.vector import Vector

CENTRAL = 0.15
"""Largest distance of an axis from the middle of its body that counts as central, as a share of the body's extent."""
NOTABLE = 0.5
"""Least cosine of the angle between an offset and a direction that it is named after."""
OBLIQUE = 0.9
"""Least cosine of the angle between an axis and the direction that names it."""


def joint_words(joint: Joint, bounds: tuple[Vector, Vector], up: Sequence[float], front: Sequence[float] | None) -> str:
    """Kind and place of a joint in a few words.

    Args:
        joint: The joint.
        bounds: Smallest and largest corner [3] of the bounding box of its body.
        up: Unit vector [3] that points up.
        front: Unit vector [3] towards the viewer. None if it is unknown.

    Returns:
        Such as "hinge, vertical, left edge", "slider, to the front" or "screw, vertical, centre". Left and right are
        those of the viewer.
    """
    sides = _sides(np.asarray(up, float), None if front is None else np.asarray(front, float))
    kind, axis = KIND_WORDS[joint.kind], joint.direction
    name, along = _nearest(axis, sides)
    if not joint.has_pivot:
        return f"{kind}, {'oblique' if along < OBLIQUE else _WAYS.get(name, name)}"
    middle, extents = 0.5 * (bounds[0] + bounds[1]), bounds[1] - bounds[0]
    offset = (joint.pivot - middle) - axis * float((joint.pivot - middle) @ axis)
    size = float(np.linalg.norm(extents - np.abs(axis) * extents))
    turning = "oblique" if along < OBLIQUE else "vertical" if name in ("top", "bottom") else "horizontal"
    if np.linalg.norm(offset) < CENTRAL * size:
        return f"{kind}, {turning}, centre"
    parts = {each: float(offset @ way) / float(np.linalg.norm(offset)) for each, way in sides.items()}
    named = [each for each in sorted(parts, key=lambda each: -parts[each]) if parts[each] > NOTABLE]
    return f"{kind}, {turning}, {' '.join(named)} edge"


_WAYS = {
    "top": "upwards",
    "bottom": "downwards",
    "front": "to the front",
    "back": "to the back",
    "left": "to the left",
    "right": "to the right",
}


def _sides(up: Vector, front: Vector | None) -> dict[str, Vector]:
    """Directions by their names. Without a front, the sides are named after the axes of the file."""
    named = {"top": up, "bottom": -up}
    if front is not None and abs(float(front @ up)) < 1e-6:
        right = np.cross(up, front)
        return named | {"front": front, "back": -front, "right": right, "left": -right}
    for name, axis in zip("xyz", np.eye(3), strict=True):
        if abs(float(axis @ up)) < 0.5:
            named |= {f"{name}+": axis, f"{name}-": -axis}
    return named


def _nearest(vector: Vector, sides: dict[str, Vector]) -> tuple[str, float]:
    """The name of the direction nearest to a vector, and the cosine of the angle to it."""
    cosines = {name: float(vector @ side) / max(float(np.linalg.norm(vector)), 1e-300) for name, side in sides.items()}
    best = max(cosines, key=lambda name: cosines[name])
    return best, cosines[best]
