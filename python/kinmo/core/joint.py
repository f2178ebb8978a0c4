"""Joints: their kind, axis and range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

MAX_VERTICAL_ANGLE = math.radians(45.0)
"""Largest angle between a vertical axis and `up`, in radians."""
MAX_AXIS_DISTANCE = 100.0
"""Largest distance of an axis from the centre of the object, and largest slide, in diagonals. Real axes are within one."""
MAX_TURNS = 100.0
"""Largest range of a hinge with limits, in turns."""


class JointKind(str, Enum):
    """The motion that a joint allows: a rotation, a translation, or both about one axis (paper, section 3.1)."""

    REVOLUTE = "R"
    PRISMATIC = "P"
    SCREW = "PR"

    @property
    def code(self) -> int:
        """Number of the kind in `kinmo._core` and in feature arrays: 0, 1 or 2."""
        return KINDS.index(self)


KINDS = tuple(JointKind)
"""All joint kinds, in the order of their codes."""
KIND_WORDS = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slider", JointKind.SCREW: "screw"}
"""Words for the kinds, as people read and write them."""


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint with one axis, in the frame and the length unit of its shape.

    Attributes:
        kind: the motion that the joint allows. A screw rotates freely while it translates.
        direction: [3], unit vector along the axis.
        pivot: [3], a point of the axis. It has no meaning for a prismatic joint.
        lower: smallest joint value, in radians (REVOLUTE) or lengths (PRISMATIC, SCREW). None without limits.
        upper: largest joint value. None without limits.
        rest: joint value of the pose in which the file shows the part.
    """

    kind: JointKind
    direction: Vector
    pivot: Vector
    lower: float | None = None
    upper: float | None = None
    rest: float = 0.0

    @property
    def is_limited(self) -> bool:
        return self.lower is not None and self.upper is not None

    @property
    def has_pivot(self) -> bool:
        """True if the position of the axis has a meaning."""
        return self.kind is not JointKind.PRISMATIC

    def reversed(self) -> Joint:
        """The same joint with the opposite direction, and with the range that belongs to it."""
        lower = None if self.upper is None else 0.0 - self.upper  # never -0.0
        upper = None if self.lower is None else 0.0 - self.lower
        return replace(self, direction=-self.direction, lower=lower, upper=upper, rest=0.0 - self.rest)

    def rotated(self, rotation: NDArray[np.float64]) -> Joint:
        """The joint in a frame that `rotation` [3, 3] rotates the present frame to."""
        return replace(self, direction=rotation @ self.direction, pivot=rotation @ self.pivot)

    def is_vertical(self, up: Vector) -> bool:
        """True if the axis is within `MAX_VERTICAL_ANGLE` of the unit vector `up` [3]."""
        return bool(abs(float(np.dot(self.direction, up))) > math.cos(MAX_VERTICAL_ANGLE))


def joint_to_data(joint: Joint) -> dict[str, Any]:
    """A joint as plain data that JSON can hold."""
    return {
        "kind": joint.kind.value,
        "direction": [float(x) for x in joint.direction],
        "pivot": [float(x) for x in joint.pivot],
        "lower": None if joint.lower is None else float(joint.lower),
        "upper": None if joint.upper is None else float(joint.upper),
        "rest": float(joint.rest),
    }


def joint_from_data(data: Mapping[str, Any]) -> Joint:
    """The inverse of `joint_to_data`.

    Raises:
        KeyError, TypeError, ValueError: the data have another form.
    """
    kind = JointKind(data["kind"])
    direction, pivot = (np.array(data[name], np.float64) for name in ("direction", "pivot"))
    return Joint(kind, direction, pivot, data["lower"], data["upper"], data["rest"])
