"""Estimates for one scan: part poses, amodal boxes, joints and joint states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.scans.poses.point_predictions import MIDDLE

F64 = NDArray[np.float64]
Poses = tuple[F64, F64, F64]
"""Rotations [P, 3, 3], scales [P] and translations [P, 3] from NPCS to the input frame. P counts all parts of some scans, one
scan after the other. Parts that were not found are NaN."""


@dataclass(frozen=True, eq=False)
class PartPoses:
    """Similarities of K parts: camera = scales [K] * rotations [K, 3, 3] @ npcs + translations [K, 3].

    Parts that were not found are NaN.
    """

    rotations: F64
    scales: F64
    translations: F64

    def apply(self, part: int, npcs: F64) -> F64:
        """Map NPCS coordinates [..., 3] of a part to the camera frame."""
        return np.asarray(self.scales[part] * npcs @ self.rotations[part].T + self.translations[part])

    @property
    def middles(self) -> F64:
        """Middles [K, 3] of the parts in the camera frame."""
        return np.stack([self.apply(part, MIDDLE) for part in range(len(self.scales))])

    @property
    def found(self) -> NDArray[np.bool_]:
        """Mask [K] of the parts that were found."""
        return np.isfinite(self.scales)


@dataclass(frozen=True, eq=False)
class ScanEstimate:
    """Estimates for one scan, in the camera's frame and lengths; unknown values are NaN.

    Attributes:
        poses: Poses of the K parts.
        centers: Centers [K, 3] of the parts' amodal boxes, whose axes are the columns of the rotations.
        half_extents: Half sides [K, 3] of the amodal boxes.
        inliers: Share [K] of each part's points that fit its RANSAC pose.
        directions: Unit directions [K - 1, 3] of the joint axes of parts 1 and up, as posed in the scan.
        pivots: Points [K - 1, 3] on these axes.
        states: Joint states [K - 1] relative to the canonical pose: rad for hinges, lengths for others.
        turns: Turns [K - 1] of screws, rad.
    """

    poses: PartPoses
    centers: F64
    half_extents: F64
    inliers: F64
    directions: F64
    pivots: F64
    states: F64
    turns: F64
