"""Negative axes for training: lines of the part's box that move it differently from the true joint (paper, section 3.3)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.config import AxisConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import Box
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.candidate_lines import box_lines
from kinmo.methods.paper.axis_selection.transformed_clouds import SCREW_SLIDES, SCREW_TURN, SLIDES

F64 = NDArray[np.float64]

PROBE_POINTS = 96
"""Points of a part that are moved; the others are the surface they are compared with."""
PROBE_TURNS = np.radians([-60.0, 30.0, 60.0])
"""Angles that hinges are compared at, in radians."""
PROBE_SLIDES = SLIDES[[1, 7]]
"""Distances that sliders are compared at, in diagonals."""
FULL_TOLERANCE_SIZE = 6.0
"""Parts with a half diagonal below 1 / 6 diagonals have a tolerance in proportion to their size."""


def negative_axes(joint: Joint, box: Box, part: NDArray[np.float32], config: AxisConfig) -> CandidateJoints:
    """Axes of a part's box that are infeasible for its true joint.

    A hinge has the 12 edges, a slider or screw the 3 centre lines.
    Axes within `near_angle` and `near_distance` of the true axis are left out. Axes with the same motion, to within
    `same_motion` diagonals (less for small parts), are left out too: other edges of the hinge side, axes of the same symmetry.

    Args:
        joint: The true joint.
        box: Box of the part.
        part ([m, 3]): Points of the part.
        config: Settings of the network.
    """
    directions, pivots, is_edge = box_lines(box)
    wanted = is_edge if joint.kind is JointKind.REVOLUTE else ~is_edge
    directions, pivots = directions[wanted], pivots[wanted]
    parallel = np.abs(directions @ joint.direction) > math.cos(math.radians(config.near_angle))
    offset = pivots - joint.pivot
    distance = np.linalg.norm(offset - (offset @ joint.direction)[:, None] * joint.direction, axis=1)
    differs = ~(parallel & ((distance < config.near_distance) | (joint.kind is JointKind.PRISMATIC)))
    if not differs.any():
        return CandidateJoints.empty()
    directions, pivots = directions[differs], pivots[differs]
    difference = motion_difference(joint, directions, pivots, part)
    tolerance = config.same_motion * min(1.0, FULL_TOLERANCE_SIZE * float(np.linalg.norm(box.half_extents)))
    directions, pivots = directions[difference > tolerance], pivots[difference > tolerance]
    count = len(directions)
    return CandidateJoints(np.full(count, joint.kind.code, np.uint8), directions, pivots, ("box",) * count)


def motion_difference(joint: Joint, directions: F64, pivots: F64, part: NDArray[np.float32]) -> F64:
    """Mean distance between a part moved by its true joint and moved along each axis, for the better sense of the axis.

    The mean distance of samples at rest is subtracted: they lie apart even where surfaces coincide.

    Args:
        joint: The true joint.
        directions ([C, 3]): Unit vectors of the axes.
        pivots ([C, 3]): Points of the axes.
        part ([m, 3]): Points of the part.

    Returns:
        [C] distances in diagonals, at least 0.
    """
    probes, rest = part[:PROBE_POINTS], part[PROBE_POINTS:]
    if len(rest) == 0:
        probes = rest = part
    surface = cKDTree(rest)
    if joint.kind is JointKind.PRISMATIC:
        angles, shifts = np.zeros(len(PROBE_SLIDES)), PROBE_SLIDES
    elif joint.kind is JointKind.REVOLUTE:
        angles, shifts = PROBE_TURNS, np.zeros(len(PROBE_TURNS))
    else:
        angles, shifts = np.full(1, SCREW_TURN), SCREW_SLIDES[-1:]
    code = np.array([joint.kind.code], np.uint8)
    moved = _core.move_points(probes, code, joint.direction[None], joint.pivot[None], angles[None], shifts[None])[0]
    codes, axes, places = np.repeat(code, 2 * len(directions)), np.tile(directions, (2, 1)), np.tile(pivots, (2, 1))
    sense = np.repeat([1.0, -1.0], len(directions))[:, None]
    gaps = []
    for cloud, angle, shift in zip(moved, angles, shifts, strict=True):
        # Moving the true cloud back along each axis needs one search tree, moving the part forward would need one per axis.
        back = _core.move_points(cloud, codes, axes, places, -angle * sense, -shift * sense)
        gaps.append(surface.query(back.reshape(-1, 3))[0].reshape(len(codes), -1).mean(axis=1))
    differences = np.mean(gaps, axis=0) - surface.query(probes)[0].mean()
    return np.asarray(np.maximum(differences.reshape(2, -1).min(axis=0), 0.0))
