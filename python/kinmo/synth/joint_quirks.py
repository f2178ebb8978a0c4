"""Joint statements as annotators make them: either sign of an axis, any point of it, limits in any order.

None of this changes which part moves or how far. Two errors are real ones, as in real files: some axes are slightly off, and
some limits leave out the pose of the file.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.synth.draw import Draw
from kinmo.synth.primitives.transforms import rotation
from kinmo.synth.synth_object import Link, Motion, SynthObject

REVERSED_HINGE_SHARE, REVERSED_SLIDER_SHARE = 0.5, 0.18
"""Shares of joints stated along the opposite direction, with negated limits."""
FULL_TURN_SHARE = 0.045
"""Share of limited hinges whose limits are off by a full turn, so that they leave out the rest value 0."""
SLACK_SHARE = 0.012
"""Share of sliders whose limits leave out the rest value 0."""
ODD_LENGTH_SHARE = 0.034
"""Share of directions that are not unit vectors."""
MOVED_ORIGIN_SHARE = 0.57
"""Share of sliders with an origin that is not zero."""
TILTED_SHARE = 0.03
"""Share of hinges whose annotated axis is off by up to 3 degrees."""
POSITION_ERROR = 0.003
"""Standard deviation of an annotated hinge position, as a fraction of the object's diagonal."""


def add_joint_quirks(obj: SynthObject, draw: Draw) -> None:
    """State every joint of a normalised object as some annotator would, in place."""
    low, high = obj.bounds()
    for link in obj.links:
        if link.motion is not None:
            motion = _with_other_origin(link, link.motion, draw, float(np.linalg.norm(high - low)))
            motion = _with_other_direction(motion, draw)
            link.motion = _with_other_limits(motion, draw)


def _with_other_origin(link: Link, motion: Motion, draw: Draw, diagonal: float) -> Motion:
    """Move the origin to another point of the axis, or of the link's box for a slider."""
    vertices = np.concatenate([piece.vertices for leaf in link.leaves() for piece in leaf.pieces])
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    inside = low + (high - low) * [draw.between(0, 1) for _ in range(3)]
    if not motion.has_position:
        return replace(motion, origin=inside) if draw.chance(MOVED_ORIGIN_SHARE) else motion
    unit = motion.direction / np.linalg.norm(motion.direction)
    target = np.zeros(3) if draw.chance(0.3) else inside
    origin = motion.origin + unit * ((target - motion.origin) @ unit)
    # The square root of 3 turns the spread of a uniform value in [-1, 1] into a standard deviation of 1.
    error = np.array([draw.between(-1, 1) for _ in range(3)]) * POSITION_ERROR * diagonal * np.sqrt(3.0)
    return replace(motion, origin=origin + error - unit * (error @ unit))


def _with_other_direction(motion: Motion, draw: Draw) -> Motion:
    """Tilt, stretch or reverse the direction."""
    if motion.is_hinge and draw.chance(TILTED_SHARE):
        about = np.array([draw.between(-1, 1) for _ in range(3)]) + 1e-6
        motion = replace(motion, direction=rotation(about, draw.between(0.2, 3.0)) @ motion.direction)
    if draw.chance(ODD_LENGTH_SHARE):
        length = draw.pick([draw.between(0.92, 0.995), draw.between(1.001, 1.04), draw.between(0.1, 0.9)], [5, 4, 1])
        motion = replace(motion, direction=length * motion.direction)
    if draw.chance(REVERSED_HINGE_SHARE if motion.is_hinge else REVERSED_SLIDER_SHARE):
        motion = replace(motion, direction=-motion.direction, a=-motion.a, b=-motion.b)
    return motion


def _with_other_limits(motion: Motion, draw: Draw) -> Motion:
    """Shift limits so that they leave out the rest value, or give a free joint numbers that mean nothing."""
    if motion.no_limit:
        return replace(motion, b=draw.pick([motion.a, 170.0, 360.0], [8, 1, 1]))
    if motion.is_hinge and draw.chance(FULL_TURN_SHARE):
        turn = 360.0 * draw.sign()
        return replace(motion, a=motion.a + turn, b=motion.b + turn)
    if not motion.is_hinge and draw.chance(SLACK_SHARE):
        slack = 0.1 * abs(motion.b - motion.a) * draw.sign()
        lowest = min(motion.a, motion.b)
        return replace(motion, a=motion.a - lowest + slack, b=motion.b - lowest + slack) if slack > 0 else motion
    return motion
