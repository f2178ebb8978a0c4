"""How far the parts and joints that were found in a scan are from the true ones (paper, section 4.2; docs/metrics.md)."""

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
from kinmo.scans.articulated_object import Extents, Structure
from kinmo.scans.point_predictions import MIDDLE
from kinmo.scans.pose_fitting import PartPoses, ScanEstimate

F64 = NDArray[np.float64]

NEAR_TURN, NEAR_PLACE = math.radians(5.0), 0.05


@dataclass(frozen=True, eq=False)
class FrameScore:
    """Errors of one scan with K parts; NaN where the part or the joint was not found.

    By part [K]: `rotation` (radians), `translation` of the part's middle by its pose, `iou` of the amodal boxes. By joint [K
    - 1]: `state` (radians, or diagonals where it slides), `turn` (radians, of a joint that slides and turns), `axis` (radians)
    and `line`, the distance of the two axes (NaN too for a joint without a pivot). Lengths are diagonals of the object.
    """

    rotation: F64
    translation: F64
    iou: F64
    state: F64
    turn: F64
    axis: F64
    line: F64

    @property
    def is_whole(self) -> bool:
        """Whether every part and the axis of every joint was found."""
        return bool(np.isfinite(self.rotation).all() and np.isfinite(self.axis).all())

    @property
    def turned_right(self) -> F64:
        """1 for each part that is turned at most 5 degrees too far, else 0 [K]; NaN where it was not found."""
        return np.where(np.isfinite(self.rotation), self.rotation <= NEAR_TURN, np.nan)

    @property
    def placed_right(self) -> F64:
        """1 for each part that moreover lies at most .05 diagonals off, else 0 [K]; NaN where it was not found."""
        return np.where(np.isfinite(self.rotation), self.turned_right * (self.translation <= NEAR_PLACE), np.nan)


def nothing_found(structure: Structure) -> FrameScore:
    """That of a scan in which nothing was found."""
    parts, joints = np.full(structure.part_count, np.nan), np.full(len(structure.kinds), np.nan)
    return FrameScore(parts, parts, parts, joints, joints, joints, joints)


def truth(poses: F64, values: F64, turns: F64, joints: Sequence[Joint], structure: Structure, extents: Extents) -> ScanEstimate:
    """What there is to find in a scan with `poses` [K, 4, 4], `values` and `turns` [K - 1] (`kinmo.scans.labelled_frames.Scans`).

    In the camera's frame; lengths are diagonals of the object, angles radians.
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
    """Errors of `found`; both in the camera's frame, in diagonals of the object."""
    turned = [_angle(mine @ right.T) for mine, right in zip(found.poses.rotations, true.poses.rotations, strict=True)]
    signs = np.where((found.directions * true.directions).sum(axis=1) < 0.0, -1.0, 1.0)  # states count along the true axis
    hinged = np.array([kind is JointKind.REVOLUTE for kind in structure.kinds], bool)
    state = np.abs(_off(signs * found.states - true.states, hinged))
    turn = np.abs(_off(signs * found.turns - true.turns, np.ones_like(hinged)))
    known = np.asarray(np.isfinite(found.directions).all(axis=1))
    axis = [axis_error(found.directions[row], true.directions[row]) if known[row] else math.nan for row in range(len(known))]
    line = [_line(found, true, row, kind) if known[row] else math.nan for row, kind in enumerate(structure.kinds)]
    return FrameScore(
        np.array(turned),
        np.linalg.norm(found.poses.middles - true.poses.middles, axis=1),
        _overlaps(found, true),
        state,
        turn,
        np.array(axis),
        np.array(line),
    )


def _angle(rotation: F64) -> float:
    return float(Rotation.from_matrix(rotation).magnitude()) if np.isfinite(rotation).all() else math.nan


def _off(off: F64, turning: NDArray[np.bool_]) -> F64:
    """Differences of states, those of what turns within half a turn."""
    return np.where(turning, (off + np.pi) % (2.0 * np.pi) - np.pi, off)


def _line(found: ScanEstimate, true: ScanEstimate, row: int, kind: JointKind) -> float:
    if kind is JointKind.PRISMATIC:
        return math.nan
    mine, right = (Joint(kind, said.directions[row], said.pivots[row]) for said in (found, true))
    return line_distance(right, mine, true.centers[row + 1])


def _overlaps(found: ScanEstimate, true: ScanEstimate) -> F64:
    overlaps = np.full(len(found.half_extents), np.nan)
    known = np.flatnonzero(found.poses.found & np.isfinite(found.half_extents).all(axis=1))
    boxes = [
        (said.centers[known], np.swapaxes(said.poses.rotations[known], 1, 2).copy(), said.half_extents[known])
        for said in (found, true)
    ]
    overlaps[known] = _core.box_iou(*boxes[0], *boxes[1])
    return overlaps
