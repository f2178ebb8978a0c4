"""Poses of the parts in which an object is scanned."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

Sampling = Literal["independent", "lockstep", "release"]
"""How joints are set: each to a value of its own, all to the same share of their ranges, or as `RELEASE_ANGLES` says."""

UNLIMITED = (-0.5 * math.pi, 0.5 * math.pi)
"""Radians to either side of the rest of a hinge without limits, and of the turn of a screw."""
ROUNDING = 1e-6
"""Of limits in files."""
RELEASE_ANGLES, RELEASE_SHIFTS = (math.radians(-90.0), math.radians(30.0)), (0.0, 0.4)
"""What the paper's release gives all hinges and all sliders, whatever their limits; lengths are shares of the diagonal."""


@dataclass(frozen=True)
class Articulation:
    """A state of all joints, by index of the body, as `kinmo.core.kinematics.forward` takes it."""

    values: Mapping[int, float]
    turns: Mapping[int, float]


def joint_range(joint: Joint) -> tuple[float, float]:
    """The values that a joint takes, from the least to the largest: its limits, or for a hinge without any a half turn."""
    if joint.lower is not None and joint.upper is not None:
        return joint.lower, joint.upper
    if joint.kind is JointKind.REVOLUTE:
        return joint.rest + UNLIMITED[0], joint.rest + UNLIMITED[1]
    return joint.rest, joint.rest


def opening(joint: Joint) -> float | None:
    """How far a hinge opens from its rest, in radians; None where that is not known."""
    if joint.kind is not JointKind.REVOLUTE or joint.lower is None or joint.upper is None:
        return None
    return max(joint.upper - joint.rest, joint.rest - joint.lower)


def opened_as_usual(mobility: Mobility, endless: float, openings: Sequence[float], rng: np.random.Generator) -> Mobility:
    """The same, its hinges that are `endless` radians wide, which says that no end is known, opening as others do.

    Each opens as far as one of `openings` (radians, of hinges of known objects), drawn at random.
    """
    if not openings:
        return mobility
    bodies = []
    for body in mobility.bodies:
        joint = body.joint
        if joint is not None and joint.kind is JointKind.REVOLUTE and joint.lower is not None and joint.upper is not None:
            wanted = openings[int(rng.integers(len(openings)))]
            if joint.upper - joint.lower >= endless - ROUNDING:
                # one that is closed between its ends opens to both sides
                lower = joint.rest - wanted if joint.rest > joint.lower + ROUNDING else joint.lower
                joint = replace(joint, lower=lower, upper=joint.rest + wanted)
        bodies.append(replace(body, joint=joint))
    return replace(mobility, bodies=tuple(bodies))


def articulations(
    mobility: Mobility, count: int, how: Sampling, rng: np.random.Generator, which: slice = slice(None)
) -> Iterator[Articulation]:
    """`count` states of the joints of `mobility`, which is in the normalised frame, or those of them that `which` says.

    In lockstep, as in the paper's pipeline, all joints go through their ranges in equal steps; else each value is drawn.
    """
    joints = {index: body.joint for index, body in mobility.movable() if body.joint is not None}
    ranges = {index: joint_range(joint) for index, joint in joints.items()}
    if how == "release":
        limits = {i: RELEASE_ANGLES if j.kind is JointKind.REVOLUTE else RELEASE_SHIFTS for i, j in joints.items()}
        ranges = {i: (low + joints[i].rest, high + joints[i].rest) for i, (low, high) in limits.items()}
    screws = [index for index, joint in joints.items() if joint.kind is JointKind.SCREW]
    for step in np.linspace(0.0, 1.0, count)[which]:

        def drawn(low: float, high: float, step: float = step) -> float:
            share = float(rng.uniform() if how == "independent" else step)
            return (1.0 - share) * low + share * high

        values = {index: drawn(*limits) for index, limits in ranges.items()}
        yield Articulation(values, {index: drawn(*UNLIMITED) for index in screws})
