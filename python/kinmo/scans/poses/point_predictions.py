"""Predictions of the networks for the points of a scan, and the part boxes and joints that follow from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.scans.object_structure import Structure
from kinmo.scans.preprocessing.input_frame import InputFrame

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

MIDDLE = np.full(3, 0.5)
"""Middle of a part in NPCS, and of the object in NAOCS."""
MIN_DIRECTION_LENGTH = 1e-6
"""Length of a median of predicted axes below which it gives no direction."""
MAX_MISFIT = 0.1
"""Largest distance of a point that fits the pose of its part, in the input frame, where the object or its visible part has the
diagonal 1."""


@dataclass(frozen=True, eq=False)
class GlobalPredictions:
    """Predictions for a scan as a whole: half sides [K, 3] of the parts' boxes in NPCS, and pivots [K - 1, 3] in NAOCS."""

    half_sizes: F64
    pivots: F64


@dataclass(frozen=True, eq=False)
class PointPredictions:
    """Predictions for the n points of one scan of an object with K parts (ANCSH, Li 2020).

    NPCS are the normalised coordinates of one part, and NAOCS those of the whole object in its canonical pose.

    Attributes:
        frame: Input frame of the scan.
        points: Points [n, 3] in the input frame.
        parts: Part [n] of each point; -1: none.
        npcs: NPCS coordinates [n, 3] of each point on its part.
        part_scales: Scales [K] from NPCS to NAOCS.
        part_shifts: Shifts [K, 3] from NPCS to NAOCS.
        joints: Joint [n] that each point votes for: j is the joint of part j, 0 none.
        axes: Axis direction [n, 3] of that joint, in NAOCS.
        pivots: Point [n, 3] on the axis of that joint, in NAOCS.
        whole: Predictions for the scan as a whole, which take precedence; None if the network makes none.
    """

    frame: InputFrame
    points: F64
    parts: I64
    npcs: F64
    part_scales: F64
    part_shifts: F64
    joints: I64
    axes: F64
    pivots: F64
    whole: GlobalPredictions | None = None

    def on_part(self, part: int) -> tuple[F64, F64]:
        """NPCS coordinates and input points of a part, both [m, 3]."""
        own = self.parts == part
        return self.npcs[own], self.points[own]

    def to_npcs(self, part: int, naocs: F64) -> F64:
        """Map NAOCS coordinates [..., 3] to the NPCS of a part."""
        return np.asarray((naocs - self.part_shifts[part]) / self.part_scales[part])


def predicted_half_sizes(predictions: PointPredictions) -> F64:
    """Half sides [K, 3] of the parts' boxes in NPCS, centered at `MIDDLE`.

    Without global predictions they enclose the visible points, and are NaN for invisible parts.
    """
    if predictions.whole is not None:
        return predictions.whole.half_sizes
    visible = (predictions.on_part(part)[0] for part in range(len(predictions.part_scales)))
    return np.array([np.abs(npcs - MIDDLE).max(axis=0) if len(npcs) else np.full(3, np.nan) for npcs in visible])


def joint_voters(predictions: PointPredictions, joint: int) -> NDArray[np.bool_]:
    """Mask [n] of the points that vote for a joint (from 1); without any, the points of the part that it moves."""
    own = predictions.joints == joint
    return np.asarray(own if own.any() else predictions.parts == joint)


def predicted_joints(predictions: PointPredictions, structure: Structure) -> tuple[F64, F64]:
    """Unit directions and pivots [K - 1, 3] of the joint axes in NAOCS: medians over the votes of points (ANCSH, Li 2020).

    They are NaN without votes. Global predictions override the pivots.
    """
    directions, pivots = (np.full((structure.part_count - 1, 3), np.nan) for _ in range(2))
    for joint in range(1, structure.part_count):
        own = joint_voters(predictions, joint)
        if own.any():
            direction = np.median(predictions.axes[own], axis=0)
            length = float(np.linalg.norm(direction))
            directions[joint - 1] = direction / length if length > MIN_DIRECTION_LENGTH else np.nan
            pivots[joint - 1] = np.median(predictions.pivots[own], axis=0)
    if predictions.whole is not None:
        pivots = predictions.whole.pivots
    return directions, pivots
