"""How far a predicted joint is from the true one (docs/metrics.md, "One joint").

Both joints are in one frame, and their lengths are in one unit: over the diagonal of the object where a limit says "diagonals".
None of the figures changes when an axis is reversed together with its range, when a pivot slides along its axis, or when the
whole scene is moved.
"""

from __future__ import annotations

import math

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector

PARALLEL_WITHIN = math.radians(1.0)
"""Axes closer than this are parallel: where two such lines pass each other says nothing about the joint."""

WHOLE_TURNS = 3
"""Ranges of hinges are compared up to this many whole turns."""


def axis_error(direction: Vector, other: Vector) -> float:
    """Angle between two undirected axes [3], of any length: radians in [0, pi/2]."""
    return math.atan2(float(np.linalg.norm(np.cross(direction, other))), abs(float(np.dot(direction, other))))


def nearest_on_line(point: Vector, pivot: Vector, direction: Vector) -> Vector:
    """The point [3] of the line through `pivot` along the unit vector `direction` that is nearest to `point`."""
    return np.asarray(pivot + np.dot(point - pivot, direction) * direction)


def point_to_line(point: Vector, pivot: Vector, direction: Vector) -> float:
    """Distance of `point` from the line through `pivot` along the unit vector `direction`."""
    return float(np.linalg.norm(np.cross(point - pivot, direction)))


def line_distance(true: Joint, predicted: Joint, near: Vector) -> float:
    """Smallest distance between the two axis lines (paper, section 4.1).

    Parallel lines (`PARALLEL_WITHIN`) are compared where the true axis passes `near` [3], the middle of the moving part.
    """
    normal = np.cross(true.direction, predicted.direction)
    if axis_error(true.direction, predicted.direction) < PARALLEL_WITHIN:
        return line_distance_at_part(true, predicted, near)
    return abs(float(np.dot(predicted.pivot - true.pivot, normal))) / float(np.linalg.norm(normal))


def line_distance_at_part(true: Joint, predicted: Joint, near: Vector) -> float:
    """Distance from the predicted axis of that point of the true axis that is nearest to `near` [3], the middle of the part.

    Unlike `line_distance` it cannot be small because two skew lines pass each other far away.
    """
    return point_to_line(nearest_on_line(near, true.pivot, true.direction), predicted.pivot, predicted.direction)


def pivot_distance(true: Joint, predicted: Joint) -> float:
    """Distance of the annotated pivot from the predicted axis; depends on where along the axis the annotator put it."""
    return point_to_line(true.pivot, predicted.pivot, predicted.direction)


def interval_iou(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Intersection over union of two intervals (lower, upper), not both of them empty."""
    shared = max(0.0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / ((first[1] - first[0]) + (second[1] - second[0]) - shared)


def limits(joint: Joint) -> tuple[float, float] | None:
    """The joint's range, None where it has none or an empty one (a file's way of saying the same)."""
    if joint.lower is None or joint.upper is None or joint.upper <= joint.lower:
        return None
    return joint.lower, joint.upper


def range_iou(true: Joint, predicted: Joint) -> float | None:
    """Overlap of the two ranges after the directions are aligned; None unless both joints are limited and of one kind.

    Of a hinge's range only the place on the circle counts: intervals may differ by whole turns.
    """
    aligned = predicted if np.dot(true.direction, predicted.direction) >= 0 else predicted.reversed()
    wanted, given = limits(true), limits(aligned)
    if wanted is None or given is None or true.kind is not predicted.kind:
        return None
    turns = range(-WHOLE_TURNS, WHOLE_TURNS + 1) if true.kind is JointKind.REVOLUTE else (0,)
    shifts = (2 * math.pi * turn for turn in turns)
    return max(interval_iou(wanted, (given[0] + shift, given[1] + shift)) for shift in shifts)
