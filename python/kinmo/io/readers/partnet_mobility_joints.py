"""Joints of mobility_v2.json."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.joint import MAX_AXIS_DISTANCE, MAX_TURNS, Joint, JointKind
from kinmo.core.vector import Vector
from kinmo.io.readers.json_field import JsonField

RIGID = frozenset({"", "free", "heavy", "static", "junk"})
"""Values of the field `joint` that mean no motion."""
_MOVABLE = {"hinge": JointKind.REVOLUTE, "slider": JointKind.PRISMATIC, "screw": JointKind.SCREW}
_TURN = 2.0 * math.pi
_UNIT_TOLERANCE = 1e-3

NoteRepair = Callable[[str], None]
"""Receives a line for each problem of a joint that is repaired."""


def read_joint(body: JsonField, note: NoteRepair) -> Joint | None:
    """The joint of a body in the frame of the file, with angles in radians. None for a rigid body.

    The file shows the body at joint value 0. A hinge range without 0 is shifted by whole turns. Any other range without 0 is
    widened to contain it. Limits in the wrong order reverse the direction. Equal limits mean no limits.
    """
    name = body["joint"].text("")
    if name in RIGID:
        return None
    if name not in _MOVABLE:
        raise body["joint"].fail(f"unknown joint {name}, expected one of {', '.join([*_MOVABLE, *sorted(RIGID - {''})])}")
    data = body["jointData"]
    limit = data["limit"]
    has_limit = not limit.is_absent
    kind = _MOVABLE[name]
    if kind is JointKind.PRISMATIC and has_limit and limit["rotates"].flag():
        kind = JointKind.SCREW
    direction, origin = _direction(data["axis"]["direction"], note), data["axis"]["origin"]
    lacks_origin = kind is JointKind.PRISMATIC and origin.is_absent  # it has no meaning there
    joint = Joint(kind, direction, np.zeros(3) if lacks_origin else origin.vector())
    if not has_limit or limit["noLimit"].flag():
        return joint
    unit = math.radians(1.0) if kind is JointKind.REVOLUTE else 1.0
    first, second = limit["a"].number() * unit, limit["b"].number() * unit
    if first == second:
        note("limits are equal: taken as unlimited")
        return joint
    lower, upper = around_rest(min(first, second), max(first, second), kind, note)
    joint = replace(joint, lower=lower, upper=upper)
    if first > second:
        note("limits are in the wrong order: direction reversed")
        return joint.reversed()
    return joint


def checked_against_bounds(
    joint: Joint, fail: Callable[[str], InputError], low: Vector, high: Vector, note: NoteRepair
) -> Joint:
    """The joint with an axis and a range that fit the size of the object, whose extreme corners [3] are `low` and `high`.

    A slider's origin far from the object is replaced by the centre, because it has no meaning. For other joints it is an error,
    which `fail` makes.
    A range beyond `MAX_TURNS` turns or `MAX_AXIS_DISTANCE` diagonals is dropped.
    """
    center, reach = 0.5 * (low + high), MAX_AXIS_DISTANCE * float(np.linalg.norm(high - low))
    if np.max(np.abs(joint.pivot - center)) > reach:
        if joint.has_pivot:
            raise fail(f"expected a point of the axis within {MAX_AXIS_DISTANCE:g} diagonals of the object")
        note("origin of a slider far from the object dropped")
        joint = replace(joint, pivot=center)
    largest = _TURN * MAX_TURNS if joint.kind is JointKind.REVOLUTE else reach
    if joint.lower is not None and joint.upper is not None and max(-joint.lower, joint.upper) > largest:
        note("limits are far too large: taken as unlimited")
        joint = replace(joint, lower=None, upper=None)
    return joint


def _direction(field: JsonField, note: NoteRepair) -> Vector:
    vector = field.vector()
    largest = float(np.max(np.abs(vector)))
    if largest == 0.0:
        raise field.fail("expected a direction, found zero")
    length = largest * float(np.linalg.norm(vector / largest))
    if abs(length - 1.0) > _UNIT_TOLERANCE:
        note(f"direction of length {length:.3g} normalised")
    scaled = vector / largest
    return np.asarray(scaled / np.linalg.norm(scaled))


def around_rest(lower: float, upper: float, kind: JointKind, note: NoteRepair) -> tuple[float, float]:
    """A range that contains 0: shifted by whole turns for a hinge if that is enough, else widened."""
    if lower <= 0.0 <= upper:
        return lower, upper
    if kind is JointKind.REVOLUTE:
        turns = _TURN * math.ceil(-upper / _TURN)
        if lower + turns <= 0.0 <= upper + turns:
            note("range shifted by whole turns to contain the rest value 0")
            return lower + turns, upper + turns
    note("range widened to contain the rest value 0")
    return min(lower, 0.0), max(upper, 0.0)
