"""Poses of the parts in which an object is scanned."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Literal

import numpy as np

from kinmo.joint import Joint, JointKind
from kinmo.mobility import Mobility

Articulation = Literal["independent", "lockstep", "release"]
"""How joints are set: each to a value of its own, all to the same share of their ranges, or all to the same angle."""

UNLIMITED = (-0.5 * math.pi, 0.5 * math.pi)
"""Radians to either side of the rest of a hinge without limits."""
RELEASE_ANGLES, RELEASE_SHIFTS = (math.radians(-90.0), math.radians(30.0)), (0.0, 0.4)
"""What the paper's release gives every hinge and every slider, whatever its limits (lengths are shares of the diagonal)."""


def joint_range(joint: Joint) -> tuple[float, float]:
    """The values that a joint takes, from the least to the largest: its limits, or for a hinge without any a half turn."""
    if joint.lower is not None and joint.upper is not None:
        return joint.lower, joint.upper
    if joint.kind is JointKind.REVOLUTE:
        return joint.rest + UNLIMITED[0], joint.rest + UNLIMITED[1]
    return joint.rest, joint.rest


def articulations(
    mobility: Mobility, count: int, how: Articulation, diagonal: float, rng: np.random.Generator
) -> Iterator[Mapping[int, float]]:
    """`count` settings of all joints: values by index of the body.

    In lockstep the ranges are gone through in equal steps, as in the paper's pipeline; else values are drawn.
    """
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    ranges = {index: joint_range(joint) for index, joint in joints.items()}
    if how == "release":
        low, high = RELEASE_SHIFTS
        shifts = low * diagonal, high * diagonal
        ranges = {i: RELEASE_ANGLES if joint.kind is JointKind.REVOLUTE else shifts for i, joint in joints.items()}
    for share in np.linspace(0.0, 1.0, count):
        shares = {index: rng.uniform() if how == "independent" else share for index in ranges}
        yield {index: (1.0 - shares[index]) * low + shares[index] * high for index, (low, high) in ranges.items()}
