"""Motion types: the ten edge types of the paper and its five coarse ones (paper, section 3.1)."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import Box
from kinmo.core.vector import Vector, distance_to_line


class MotionType(IntEnum):
    """The ten edge types of the paper, in the order of its code.

    A name begins with the joint kind: P, R or PR. The next letter is the direction of the axis: H for horizontal, V for
    vertical. The last one is the position of a revolute axis: C for central, S for a side of the part.
    """

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
        """The kind of joint. None for FIXED and NONE."""
        return None if self >= MotionType.FIXED else JointKind(self.name.split("_")[0])

    @property
    def coarse(self) -> CoarseType:
        """The coarse type: without direction and position of the axis."""
        return CoarseType[self.name.split("_")[0]]

    @property
    def is_vertical(self) -> bool:
        return "_V" in self.name

    @property
    def is_central(self) -> bool:
        """True for a revolute axis that runs through the middle of the part, not along a side."""
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
        """The kind of joint. None for FIXED and NONE."""
        return None if self >= CoarseType.FIXED else JointKind(self.name)


def motion_type(joint: Joint, box: Box, up: Vector) -> MotionType:
    """The fine motion type of the joint of a moving part, from the part's oriented box and the unit vector `up` [3].

    The axis is vertical (V) within 45 degrees of `up`, else horizontal (H). A revolute axis is central (C) if the centre of the
    box is nearer to it than every corner, else at a side (S).
    """
    orientation = "V" if joint.is_vertical(up) else "H"
    if joint.kind is not JointKind.REVOLUTE:
        return MotionType[f"{joint.kind.value}_{orientation}"]
    places = np.vstack([box.corners(), box.center])
    nearest = int(np.argmin(distance_to_line(places, joint.pivot, joint.direction)))
    return MotionType[f"R_{orientation}_{'C' if nearest == 8 else 'S'}"]
