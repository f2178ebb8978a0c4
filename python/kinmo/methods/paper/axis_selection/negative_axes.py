"""Wrong axes to learn from: those of the part's box that do not do what the true joint does (paper, section 3.3)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.config import AxisConfig
from kinmo.core.box import Box
from kinmo.core.joint import Joint, JointKind
from kinmo.features.candidate_joints import Candidates, no_candidates
from kinmo.features.candidate_lines import box_lines
from kinmo.methods.paper.axis_selection.motion_clouds import SCREW_SLIDES, SCREW_TURN, SLIDES

F64 = NDArray[np.float64]

PROBES = 96
PROBED_TURNS = np.radians([-60.0, 30.0, 60.0])
PROBED_SLIDES = SLIDES[[1, 7]]


def negative_candidates(joint: Joint, box: Box, part: NDArray[np.float32], config: AxisConfig) -> Candidates:
    """The axes of `box` along which the part, points [m, 3], would not move as `joint` says.

    A hinge has the 12 edges (and with `lines` the 3 centre lines), a slider and a screw the 3 axes through the centre. Left out
    are those within `near_angle` and `near_distance` of the truth, and those that move the points to where the truth does
    (`same_motion` diagonals, less for small parts): the same hinge side, or any axis of the same symmetry.
    """
    directions, pivots, is_edge = box_lines(box)
    wanted = ~is_edge
    if joint.kind is JointKind.REVOLUTE:
        wanted = is_edge | (config.negatives == "lines")
    directions, pivots = directions[wanted], pivots[wanted]
    parallel = np.abs(directions @ joint.direction) > math.cos(math.radians(config.near_angle))
    offset = pivots - joint.pivot
    across = np.linalg.norm(offset - (offset @ joint.direction)[:, None] * joint.direction, axis=1)
    keep = ~(parallel & ((across < config.near_distance) | (joint.kind is JointKind.PRISMATIC)))
    if not keep.any():
        return no_candidates()
    directions, pivots = directions[keep], pivots[keep]
    differs = motion_difference(joint, directions, pivots, part)
    tolerance = config.same_motion * min(1.0, 6.0 * float(np.linalg.norm(box.half_extents)))
    directions, pivots = directions[differs > tolerance], pivots[differs > tolerance]
    count = len(directions)
    return Candidates(np.full(count, joint.kind.code, np.uint8), directions, pivots, ("box",) * count)


def motion_difference(joint: Joint, directions: F64, pivots: F64, part: NDArray[np.float32]) -> F64:
    """How far from each other [C] the true joint and each axis take the part, as sets of points, in either sense of the axis.

    The mean distance from moved points to the nearest of the others, less what it is at rest: points are samples, and lie apart
    even where the surfaces coincide.
    """
    probes, rest = part[:PROBES], part[PROBES:]
    if len(rest) == 0:
        probes = rest = part
    surface = cKDTree(rest)
    if joint.kind is JointKind.PRISMATIC:
        angles, shifts = np.zeros(len(PROBED_SLIDES)), PROBED_SLIDES
    elif joint.kind is JointKind.REVOLUTE:
        angles, shifts = PROBED_TURNS, np.zeros(len(PROBED_TURNS))
    else:
        angles, shifts = np.full(1, SCREW_TURN), SCREW_SLIDES[-1:]
    code = np.array([joint.kind.code], np.uint8)
    moved = _core.move_points(probes, code, joint.direction[None], joint.pivot[None], angles[None], shifts[None])[0]
    codes, axes, places = np.repeat(code, 2 * len(directions)), np.tile(directions, (2, 1)), np.tile(pivots, (2, 1))
    sense = np.repeat([1.0, -1.0], len(directions))[:, None]
    gaps = []
    for cloud, angle, shift in zip(moved, angles, shifts, strict=True):
        # moving the true cloud back along each axis, and not the part along it, leaves the part's search tree as it is
        back = _core.move_points(cloud, codes, axes, places, -angle * sense, -shift * sense)
        gaps.append(surface.query(back.reshape(-1, 3))[0].reshape(len(codes), -1).mean(axis=1))
    differences = np.mean(gaps, axis=0) - surface.query(probes)[0].mean()
    return np.asarray(np.maximum(differences.reshape(2, -1).min(axis=0), 0.0))
