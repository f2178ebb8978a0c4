"""Errors of the parts and joints that were found in a scan (paper, section 4.2; docs/background/metrics.md, "Scans")."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.evaluation.metrics import axis_error, line_distance
from kinmo.scans.object_structure import Extents, Structure
from kinmo.scans.poses.point_predictions import MIDDLE
from kinmo.scans.poses.scan_estimate import PartPoses, ScanEstimate

F64 = NDArray[np.float64]

MAX_ROTATION_ERROR = math.radians(5.0)
"""Largest rotation error of an accurate part pose, in radians (ANCSH's accuracy at 5 degrees)."""
MAX_TRANSLATION_ERROR = 0.05  # largest translation error of an accurate part pose, in diagonals


@dataclass(frozen=True, eq=False)
class FrameScore:
    """Errors of one scan with K parts. NaN where the part or the joint was not found. Lengths are diagonals of the object."""

    rotation: F64  # rotation errors of the parts [K], in radians
    translation: F64  # distances of the parts' middles from the true ones [K]
    iou: F64  # overlaps of the amodal boxes [K]
    state: F64  # errors of the joint states [K - 1], in radians, or in diagonals where the joint slides
    turn: F64  # errors of the turn of joints that slide and turn [K - 1], in radians
    axis: F64  # angles between the joint axes [K - 1], in radians
    line: F64  # distances of the joint axes [K - 1]; NaN too for a joint without a pivot

    @property
    def is_whole(self) -> bool:
        """True if every part and the axis of every joint was found."""
        return bool(np.isfinite(self.rotation).all() and np.isfinite(self.axis).all())

    @property
    def rotation_ok(self) -> F64:
        """1 for each part with a rotation error of at most 5 degrees, else 0 [K]; NaN where it was not found."""
        return np.where(np.isfinite(self.rotation), self.rotation <= MAX_ROTATION_ERROR, np.nan)

    @property
    def pose_ok(self) -> F64:
        """1 for each part with `rotation_ok` and at most 0.05 diagonals of translation error, else 0 [K]; NaN if not found."""
        return np.where(np.isfinite(self.rotation), self.rotation_ok * (self.translation <= MAX_TRANSLATION_ERROR), np.nan)


def nothing_found(structure: Structure) -> FrameScore:
    """The score of a scan in which nothing was found."""
    parts, joints = np.full(structure.part_count, np.nan), np.full(len(structure.kinds), np.nan)
    return FrameScore(parts, parts, parts, joints, joints, joints, joints)


def true_scan_estimate(
    poses: F64, values: F64, turns: F64, joints: Sequence[Joint], structure: Structure, extents: Extents
) -> ScanEstimate:
    """The true parts and joints of a scan in the form of an estimate, in the camera's frame and in diagonals of the object.

    The true poses [K, 4, 4] of the parts lead from the normalised frame, in which joints and boxes are, to the camera's. Values
    [K - 1] of the joints are in radians, or in diagonals where the joint slides. Turns [K - 1] of screws are in radians.
    """
    rotations, sizes = poses[:, :3, :3], extents.diagonals
    corners = extents.centers - MIDDLE * sizes[:, None]
    shifts = np.einsum("kij,kj->ki", rotations, corners) + poses[:, :3, 3]
    above = poses[list(structure.parents)]
    directions = np.stack([pose[:3, :3] @ joint.direction for pose, joint in zip(above, joints, strict=True)])
    pivots = np.stack([pose[:3, :3] @ joint.pivot + pose[:3, 3] for pose, joint in zip(above, joints, strict=True)])
    states = values - np.array([joint.rest for joint in joints])
    turns = np.where([joint.kind is JointKind.SCREW for joint in joints], turns, np.nan)
    placed = PartPoses(rotations, sizes, shifts)
    return ScanEstimate(placed, placed.middles, 0.5 * extents.sizes, np.ones(len(sizes)), directions, pivots, states, turns)


def score_frame(found: ScanEstimate, true: ScanEstimate, structure: Structure) -> FrameScore:
    """Errors of an estimate. Both estimates are in the camera's frame, in diagonals of the object (`true_scan_estimate`)."""
    rotation = [_angle(mine @ right.T) for mine, right in zip(found.poses.rotations, true.poses.rotations, strict=True)]
    signs = np.where((found.directions * true.directions).sum(axis=1) < 0.0, -1.0, 1.0)  # states count along the true axis
    hinged = np.array([kind is JointKind.REVOLUTE for kind in structure.kinds], bool)
    state = np.abs(_difference(signs * found.states - true.states, hinged))
    turn = np.abs(_difference(signs * found.turns - true.turns, np.ones_like(hinged)))
    known = np.asarray(np.isfinite(found.directions).all(axis=1))
    axis = [axis_error(found.directions[row], true.directions[row]) if known[row] else math.nan for row in range(len(known))]
    line = [_line(found, true, row, kind) if known[row] else math.nan for row, kind in enumerate(structure.kinds)]
    return FrameScore(
        np.array(rotation),
        np.linalg.norm(found.poses.middles - true.poses.middles, axis=1),
        _box_overlaps(found, true),
        state,
        turn,
        np.array(axis),
        np.array(line),
    )


def _angle(rotation: F64) -> float:
    return float(Rotation.from_matrix(rotation).magnitude()) if np.isfinite(rotation).all() else math.nan


def _difference(difference: F64, turning: NDArray[np.bool_]) -> F64:
    """Differences of states, wrapped to half a turn where the joint is turning."""
    return np.where(turning, (difference + np.pi) % (2.0 * np.pi) - np.pi, difference)


def _line(found: ScanEstimate, true: ScanEstimate, row: int, kind: JointKind) -> float:
    if kind is JointKind.PRISMATIC:
        return math.nan
    mine, right = (Joint(kind, estimate.directions[row], estimate.pivots[row]) for estimate in (found, true))
    return line_distance(right, mine, true.centers[row + 1])


def _box_overlaps(found: ScanEstimate, true: ScanEstimate) -> F64:
    overlaps = np.full(len(found.half_extents), np.nan)
    known = np.flatnonzero(found.poses.found & np.isfinite(found.half_extents).all(axis=1))
    boxes = [
        (own.centers[known], np.swapaxes(own.poses.rotations[known], 1, 2).copy(), own.half_extents[known])
        for own in (found, true)
    ]
    overlaps[known] = _core.box_iou(*boxes[0], *boxes[1])
    return overlaps
