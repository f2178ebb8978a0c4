"""Joint states in which an object is scanned."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

DEFAULT_RANGE = (-0.5 * math.pi, 0.5 * math.pi)
"""Range of a hinge without limits around its rest, and of a screw's turn; rad."""
RELEASE_ANGLES, RELEASE_SHIFTS = (math.radians(-90.0), math.radians(30.0)), (0.0, 0.4)
"""Ranges of all hinges (rad) and all sliders (diagonals) in the paper's release, whatever their limits."""


@dataclass(frozen=True)
class JointStates:
    """Values and turns of all joints by body index, as `kinmo.core.kinematics.forward` takes them."""

    values: Mapping[int, float]
    turns: Mapping[int, float]


def joint_range(joint: Joint) -> tuple[float, float]:
    """Smallest and largest value of a joint.

    These are its limits. A hinge without limits turns a quarter to either side of its rest; other joints without limits stay.
    """
    if joint.lower is not None and joint.upper is not None:
        return joint.lower, joint.upper
    if joint.kind is JointKind.REVOLUTE:
        return joint.rest + DEFAULT_RANGE[0], joint.rest + DEFAULT_RANGE[1]
    return joint.rest, joint.rest


def sample_joint_states(
    mobility: Mobility, count: int, rng: np.random.Generator, subset: slice = slice(None), *, like_release: bool = False
) -> Iterator[JointStates]:
    """Sample states of all joints.

    Args:
        mobility: Joints in the normalised frame.
        count: Number of states.
        rng: Source of random numbers.
        subset: Selects some of the `count` states.
        like_release: True to move all joints in equal steps through `RELEASE_ANGLES` and `RELEASE_SHIFTS`, False to draw each
            value from its joint's range.

    Yields:
        The selected states.
    """
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    ranges = {index: joint_range(joint) for index, joint in joints.items()}
    if like_release:
        limits = {i: RELEASE_ANGLES if j.kind is JointKind.REVOLUTE else RELEASE_SHIFTS for i, j in joints.items()}
        ranges = {i: (low + joints[i].rest, high + joints[i].rest) for i, (low, high) in limits.items()}
    screws = [index for index, joint in joints.items() if joint.kind is JointKind.SCREW]
    for step in np.linspace(0.0, 1.0, count)[subset]:

        def sample(low: float, high: float, step: float = step) -> float:
            share = float(step if like_release else rng.uniform())
            return (1.0 - share) * low + share * high

        values = {index: sample(*limits) for index, limits in ranges.items()}
        yield JointStates(values, {index: sample(*DEFAULT_RANGE) for index in screws})
