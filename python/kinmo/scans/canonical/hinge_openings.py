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

    A hinge at least `max_guessed_opening` wide has no known end: limits are guessed up to that width.

    Args:
        mobility: The object's joints, at rest where they are closed.
        max_guessed_opening: Largest width of a guessed range, rad.
        openings: Openings of hinges of labelled objects, rad (`hinge_opening`). Without any, nothing changes.
        rng: Source of random numbers.

    Returns:
        The mobility whose hinges without a known end open as far as one of `openings`, drawn at random.
    """
    if not openings:
        return mobility
    bodies = []
    for body in mobility.bodies:
        joint = body.joint
        if joint is not None and joint.kind is JointKind.REVOLUTE and joint.lower is not None and joint.upper is not None:
            opening = openings[int(rng.integers(len(openings)))]
            if joint.upper - joint.lower >= max_guessed_opening - ROUNDING:
                # A hinge that is closed between its ends opens to both sides.
                lower = joint.rest - opening if joint.rest > joint.lower + ROUNDING else joint.lower
                joint = replace(joint, lower=lower, upper=joint.rest + opening)
        bodies.append(replace(body, joint=joint))
    return replace(mobility, bodies=tuple(bodies))
