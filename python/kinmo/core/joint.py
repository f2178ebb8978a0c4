"""Joints and their types (paper, section 3.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.vector import Vector

VERTICAL_WITHIN = math.radians(45.0)
"""An axis within this angle of `up` is vertical (reference reading of H and V)."""


class JointKind(str, Enum):
    """What a joint lets a part do: turn, slide, or both about one axis (a screw)."""

    REVOLUTE = "R"
    PRISMATIC = "P"
    SCREW = "PR"

    @property
    def code(self) -> int:
        """Number of the kind in the geometry core and in arrays of features: 0, 1 or 2."""
        return KINDS.index(self)


KINDS = tuple(JointKind)
"""Kinds of joints in the order in which the geometry core numbers them."""


class MotionType(IntEnum):
    """The ten edge types of the paper, in the order of its release."""

    P_H = 0
    P_V = 1
    R_H_C = 2
    R_H_S = 3
    R_V_C = 4
    R_V_S = 5
    PR_H = 6
    PR_V = 7
    FIXED = 8
    NONE = 9

    @property
    def kind(self) -> JointKind | None:
        """The kind of joint, None for FIXED and NONE."""
        return None if self >= MotionType.FIXED else JointKind(self.name.split("_")[0])

    @property
    def coarse(self) -> CoarseType:
        """The same without direction and place."""
        return CoarseType[self.name.split("_")[0]]

    @property
    def is_vertical(self) -> bool:
        return "_V" in self.name

    @property
    def is_central(self) -> bool:
        """Whether a revolute axis runs through the middle of the part rather than along a side."""
        return self.name.endswith("_C")


class CoarseType(IntEnum):
    """The five edge types of the coarse model."""

    P = 0
    R = 1
    PR = 2
    FIXED = 3
    NONE = 4

    @property
    def kind(self) -> JointKind | None:
        """The kind of joint, None for FIXED and NONE."""
        return None if self >= CoarseType.FIXED else JointKind(self.name)


@dataclass(frozen=True, eq=False)
class Joint:
    """A one-axis joint.

    `direction` [3] is a unit vector, `pivot` [3] a point of the axis (without meaning for PRISMATIC), both in the frame and the
    lengths of the shape. `lower <= upper` is the range along or about `direction`, from the pose of the file: radians for
    REVOLUTE, lengths for PRISMATIC and SCREW; both None where the joint has no limit. `rest` is the value at which the file
    shows the part. A screw turns freely while it slides.
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
        """Whether the place of the axis means something."""
        return self.kind is not JointKind.PRISMATIC

    def reversed(self) -> Joint:
        """The same joint with its direction, and with it its range, turned round."""
        lower = None if self.upper is None else -self.upper
        upper = None if self.lower is None else -self.lower
        return replace(self, direction=-self.direction, lower=lower, upper=upper, rest=-self.rest)

    def turned(self, rotation: NDArray[np.float64]) -> Joint:
        """The same joint in a frame to which `rotation` [3, 3] takes this one's."""
        return replace(self, direction=rotation @ self.direction, pivot=rotation @ self.pivot)

    def is_vertical(self, up: Vector) -> bool:
        return bool(abs(float(np.dot(self.direction, up))) > math.cos(VERTICAL_WITHIN))


def joint_to_data(joint: Joint) -> dict[str, Any]:
    """A joint as plain data."""
    return {
        "kind": joint.kind.value,
        "direction": [float(x) for x in joint.direction],
        "pivot": [float(x) for x in joint.pivot],
        "lower": joint.lower,
        "upper": joint.upper,
        "rest": joint.rest,
    }


def joint_from_data(data: Mapping[str, Any]) -> Joint:
    """What `joint_to_data` took apart. Raises KeyError, TypeError or ValueError for anything else."""
    return Joint(
        JointKind(data["kind"]),
        np.array(data["direction"], np.float64),
        np.array(data["pivot"], np.float64),
        data["lower"],
        data["upper"],
        data["rest"],
    )
