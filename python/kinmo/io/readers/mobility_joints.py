"""Joints of mobility_v2.json."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector
from kinmo.io.readers.field import Field

RIGID = frozenset({"", "free", "heavy", "static", "junk"})
"""Joints that let nothing move."""
_MOVABLE = {"hinge": JointKind.REVOLUTE, "slider": JointKind.PRISMATIC, "screw": JointKind.SCREW}
_TURN = 2.0 * math.pi
FARTHEST = 100.0
"""Diagonals of the object from its middle to an axis; those of real objects are within one."""
MOST_TURNS = 100.0
"""Of a hinge with limits."""
_UNIT_WITHIN = 1e-3


def read_joint(body: Field, repairs: list[str], body_name: str) -> Joint | None:
    """The joint of an entry of mobility_v2.json, None if it is rigid; what was mended is added to `repairs`.

    Limits from high to low turn the direction round; equal ones mean that there are none. The file shows the part at 0: a range
    without 0 is shifted by whole turns (hinges), or widened to contain it.
    """
    word = body["joint"].text("")
    if word in RIGID:
        return None
    if word not in _MOVABLE:
        raise body["joint"].fail(f"unknown joint {word}, expected one of {', '.join([*_MOVABLE, *sorted(RIGID - {''})])}")
    data = body["jointData"]
    limit = data["limit"]
    has_limit = not limit.is_absent
    kind = _MOVABLE[word]
    if kind is JointKind.PRISMATIC and has_limit and limit["rotates"].flag():
        kind = JointKind.SCREW
    mend = _Mender(repairs, body_name)
    direction = _direction(data["axis"]["direction"], mend)
    pivot = _pivot(data["axis"]["origin"], kind)
    joint = Joint(kind, direction, pivot)
    if not has_limit or limit["noLimit"].flag():
        return joint
    unit = math.radians(1.0) if kind is JointKind.REVOLUTE else 1.0
    first, second = limit["a"].number() * unit, limit["b"].number() * unit
    if first == second:
        mend("limits are equal: taken as unlimited")
        return joint
    lower, upper = _around_rest(min(first, second), max(first, second), kind, mend)
    joint = Joint(kind, direction, pivot, lower, upper)
    if first > second:
        mend("limits are reversed: direction turned round")
        return joint.reversed()
    return joint


def joint_near(joint: Joint, body: Field, low: Vector, high: Vector, repairs: list[str], body_name: str) -> Joint:
    """The joint, which must be near to the object between the corners `low` and `high` [3].

    Raises InputError for an axis farther than `FARTHEST` diagonals from it. Where the origin of a slider, which means nothing,
    is as far it is dropped; a range beyond that, or of more than `MOST_TURNS` turns, is taken for none.
    """
    mend = _Mender(repairs, body_name)
    center, reach = 0.5 * (low + high), FARTHEST * float(np.linalg.norm(high - low))
    if np.max(np.abs(joint.pivot - center)) > reach:
        if joint.has_pivot:
            raise body["jointData"]["axis"]["origin"].fail(
                f"expected a point of the axis within {FARTHEST:g} diagonals of the object"
            )
        mend("origin of a slider far from the object dropped")
        joint = replace(joint, pivot=center)
    farthest = _TURN * MOST_TURNS if joint.kind is JointKind.REVOLUTE else reach
    if joint.lower is not None and joint.upper is not None and max(-joint.lower, joint.upper) > farthest:
        mend("limits beyond all sense: taken as unlimited")
        joint = replace(joint, lower=None, upper=None)
    return joint


class _Mender:
    """Notes what was mended about the joint of one body."""

    def __init__(self, repairs: list[str], name: str) -> None:
        self.repairs, self.name = repairs, name

    def __call__(self, what: str) -> None:
        self.repairs.append(f"joint of {self.name}: {what}")


def _direction(field: Field, mend: _Mender) -> Vector:
    vector = field.vector()
    largest = float(np.max(np.abs(vector)))
    if largest == 0.0:
        raise field.fail("expected a direction, found zero")
    length = largest * float(np.linalg.norm(vector / largest))
    if abs(length - 1.0) > _UNIT_WITHIN:
        mend(f"direction of length {length:.3g} normalised")
    scaled = vector / largest
    unit: Vector = scaled / np.linalg.norm(scaled)
    return unit


def _pivot(field: Field, kind: JointKind) -> Vector:
    """A slider's origin means nothing, and is not asked for."""
    if kind is JointKind.PRISMATIC and field.is_absent:
        return np.zeros(3)
    return field.vector()


def _around_rest(lower: float, upper: float, kind: JointKind, mend: _Mender) -> tuple[float, float]:
    if lower <= 0.0 <= upper:
        return lower, upper
    if kind is JointKind.REVOLUTE:
        turns = _TURN * math.ceil(-upper / _TURN)
        if lower + turns <= 0.0 <= upper + turns:
            mend("range shifted by whole turns to contain the rest value 0")
            return lower + turns, upper + turns
    mend("range widened to contain the rest value 0")
    return min(lower, 0.0), max(upper, 0.0)
