"""Joint axes and joint states from part poses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.joint import JointKind
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import MIDDLE, PointPredictions
from kinmo.scans.poses.scan_estimate import PartPoses

F64 = NDArray[np.float64]


def estimate_joints(
    poses: PartPoses,
    predictions: PointPredictions,
    axes: tuple[F64, F64],
    structure: Structure,
    prior: CategoryPrior,
    *,
    average_pivots: bool,
) -> tuple[F64, F64, F64, F64]:
    """Estimate joint axes and states from part poses.

    The pose of the parent turns the axis and places its pivot.

    Args:
        poses: Poses of the K parts.
        predictions: Predictions for the scan.
        axes: Directions and pivots [K - 1, 3] of the joints in NAOCS.
        structure: Structure of the object.
        prior: Category prior; its usual ranges fix the number of whole turns.
        average_pivots: True to average the pivots that both parts of a joint give, False to take the parent's.

    Returns:
        Directions, pivots [K - 1, 3], states and turns [K - 1] of the joints, as in `ScanEstimate`.
    """
    directions, pivots = (np.full((structure.part_count - 1, 3), np.nan) for _ in range(2))
    states, turns = (np.full(structure.part_count - 1, np.nan) for _ in range(2))
    for row, (kind, parent) in enumerate(zip(structure.kinds, structure.parents, strict=True)):
        part, direction, pivot = row + 1, axes[0][row], axes[1][row]
        directions[row] = poses.rotations[parent] @ direction
        holders = [parent, part] if average_pivots and poses.found[part] else [parent]
        pivots[row] = np.mean([poses.apply(each, predictions.to_npcs(each, pivot)) for each in holders], axis=0)
        if poses.found[part] and poses.found[parent] and np.isfinite(direction).all():
            turn = turn_about(poses.rotations[parent].T @ poses.rotations[part], direction)
            turn = with_usual_turns(turn, prior.turn_ranges[row])
            states[row] = turn if kind is JointKind.REVOLUTE else _slide(poses, part, parent, direction, predictions)
            turns[row] = turn if kind is JointKind.SCREW else np.nan
    return directions, pivots, states, turns


def _slide(poses: PartPoses, part: int, parent: int, direction: F64, predictions: PointPredictions) -> float:
    """Displacement along the axis: from where the parent would have carried the part's middle to where that is."""
    middle = predictions.part_scales[part] * MIDDLE + predictions.part_shifts[part]
    carried = poses.apply(parent, predictions.to_npcs(parent, middle))
    return float((poses.apply(part, MIDDLE) - carried) @ (poses.rotations[parent] @ direction))


def with_usual_turns(turn: float, usual: F64) -> float:
    """Add whole turns to an angle (rad) to bring it nearest to the middle of a range [2]; NaN ranges change nothing."""
    middle = usual.mean()
    return turn + 2.0 * np.pi * round((middle - turn) / (2.0 * np.pi)) if np.isfinite(middle) else turn


def turn_about(rotation: F64, direction: F64) -> float:
    """Angle in (-pi, pi] about the unit vector `direction` [3] that comes nearest to `rotation` [3, 3]."""
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(np.pi - (np.pi - 2.0 * np.arctan2(np.dot([x, y, z], direction), w)) % (2.0 * np.pi))
