"""Openings of hinges, and their replacement where a guessed limit is no real end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

ROUNDING = 1e-6
"""Rounding error of limits in files, rad."""


def hinge_opening(joint: Joint) -> float | None:
    """Largest angle (rad) to which a hinge opens from its rest; None for other joints and without limits."""
    if joint.kind is not JointKind.REVOLUTE or joint.lower is None or joint.upper is None:
        return None
    return max(joint.upper - joint.rest, joint.rest - joint.lower)


def with_sampled_openings(
    mobility: Mobility, max_guessed_opening: float, openings: Sequence[float], rng: np.random.Generator
) -> Mobility:
    """Replace guessed ends of hinges by openings of known hinges.

    A hinge at least `max_guessed_opening` rad wide has no known end: limits are guessed up to that width. It gets one of
    `openings` (`hinge_opening` of labelled objects), drawn at random. Without any, nothing changes.
    """

    def opened(joint: Joint) -> Joint:
        if joint.kind is not JointKind.REVOLUTE or joint.lower is None or joint.upper is None:
            return joint
        opening = openings[int(rng.integers(len(openings)))]
        if joint.upper - joint.lower < max_guessed_opening - ROUNDING:
            return joint
        # A hinge that is closed between its ends opens to both sides.
        lower = joint.rest - opening if joint.rest > joint.lower + ROUNDING else joint.lower
        return replace(joint, lower=lower, upper=joint.rest + opening)

    return mobility.with_joints(opened) if openings else mobility
