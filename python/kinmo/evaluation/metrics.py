"""Errors of a predicted joint against the true one, and the criterion of an ok joint (docs/background/metrics.md, "One joint").

Both joints are in one frame and in one unit of length. Limits in diagonals need lengths over the diagonal of the object's box.
No error changes when an axis is reversed together with its range, when a pivot slides along its axis, or when the scene moves.
"""

from __future__ import annotations

import math

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector

MAX_AXIS_ERROR = math.radians(5.0)  # largest axis error of an ok joint, in radians
MAX_LINE_DISTANCE = 0.05  # largest distance of the axis line of an ok joint, in diagonals
PARALLEL_ANGLE = math.radians(1.0)
"""Axes closer than this angle (rad) count as parallel. Where two such lines pass each other says nothing about the joint."""
MAX_WHOLE_TURNS = 3  # ranges of hinges are compared up to this many whole turns apart


def is_axis_ok(axis_error: float | None) -> bool:
    """True for an axis error (rad) of at most `MAX_AXIS_ERROR`; False for None, a joint without an axis."""
    return axis_error is not None and axis_error <= MAX_AXIS_ERROR


def is_line_ok(distance: float | None) -> bool:
    """True for a line distance (diagonals) of at most `MAX_LINE_DISTANCE`; False for None, a joint without a line."""
    return distance is not None and distance <= MAX_LINE_DISTANCE


def is_axis_and_line_ok(true_kind: JointKind, axis_error: float | None, line_at_part: float | None) -> bool:
    """The criterion of an ok joint (`is_ok`) without its kind. A true slider has no line, so only its axis counts."""
    return is_axis_ok(axis_error) and (true_kind is JointKind.PRISMATIC or is_line_ok(line_at_part))


def is_ok(true_kind: JointKind, predicted_kind: JointKind | None, axis_error: float | None, line_at_part: float | None) -> bool:
    """The criterion of an ok joint: right kind, axis within 5 degrees, and unless it slides the line within 0.05 diagonals.

    All tables, reports and the scoring of URDF files use this one definition. Without a prediction, kind and error are None.
    The distance `line_at_part` (`line_distance_at_part`, in diagonals) is None if either joint is a slider.

    Example:
        >>> is_ok(JointKind.REVOLUTE, JointKind.REVOLUTE, math.radians(4.0), 0.01)
        True
    """
    return predicted_kind is true_kind and is_axis_and_line_ok(true_kind, axis_error, line_at_part)


def axis_error(direction: Vector, other: Vector) -> float:
    """Angle between two undirected axes [3] of any length, in radians from 0 to pi / 2."""
    return math.atan2(float(np.linalg.norm(np.cross(direction, other))), abs(float(np.dot(direction, other))))


def point_to_line(point: Vector, pivot: Vector, direction: Vector) -> float:
    """Distance of `point` from the line through `pivot` along the unit vector `direction`."""
    return float(np.linalg.norm(np.cross(point - pivot, direction)))


def line_distance(true: Joint, predicted: Joint, near: Vector) -> float:
    """Smallest distance between the two axis lines (paper, section 4.1).

    Lines that are parallel within `PARALLEL_ANGLE` are compared at `near` [3], the middle of the moving part's box.
    """
    normal = np.cross(true.direction, predicted.direction)
    if axis_error(true.direction, predicted.direction) < PARALLEL_ANGLE:
        return line_distance_at_part(true, predicted, near)
    return abs(float(np.dot(predicted.pivot - true.pivot, normal))) / float(np.linalg.norm(normal))


def line_distance_at_part(true: Joint, predicted: Joint, near: Vector) -> float:
    """Distance of the predicted axis from the point of the true axis nearest to `near` [3], the middle of the part's box.

    It is stricter than `line_distance` where two skew lines pass each other far from the part.
    """
    nearest = true.pivot + np.dot(near - true.pivot, true.direction) * true.direction
    return point_to_line(nearest, predicted.pivot, predicted.direction)


def pivot_distance(true: Joint, predicted: Joint) -> float:
    """Distance of the annotated pivot from the predicted axis. It depends on where on the axis the annotator put the pivot."""
    return point_to_line(true.pivot, predicted.pivot, predicted.direction)


def interval_iou(first: tuple[float, float], second: tuple[float, float]) -> float:
    """Intersection over union of two intervals (lower, upper), of which at least one is not empty."""
    shared = max(0.0, min(first[1], second[1]) - max(first[0], second[0]))
    return shared / ((first[1] - first[0]) + (second[1] - second[0]) - shared)


def limits(joint: Joint) -> tuple[float, float] | None:
    """The joint's range (lower, upper); None for an unlimited joint and for an empty range."""
    if joint.lower is None or joint.upper is None or joint.upper <= joint.lower:
        return None
    return joint.lower, joint.upper


def range_iou(true: Joint, predicted: Joint) -> float | None:
    """Intersection over union of the two ranges after their directions are aligned, up to `MAX_WHOLE_TURNS` of a hinge.

    None unless both joints are limited and of the same kind.
    """
    aligned = predicted if np.dot(true.direction, predicted.direction) >= 0 else predicted.reversed()
    true_range, predicted_range = limits(true), limits(aligned)
    if true_range is None or predicted_range is None or true.kind is not predicted.kind:
        return None
    turns = range(-MAX_WHOLE_TURNS, MAX_WHOLE_TURNS + 1) if true.kind is JointKind.REVOLUTE else (0,)
    lower, upper = predicted_range
    return max(interval_iou(true_range, (lower + 2 * math.pi * turn, upper + 2 * math.pi * turn)) for turn in turns)
