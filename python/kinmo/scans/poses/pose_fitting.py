"""Pose fitting: from point predictions to part poses, amodal boxes, joints and joint states (ANCSH, Li 2020, section 4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.axis_snapping import snap_directions
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.point_predictions import MAX_MISFIT, MIDDLE, PointPredictions, predicted_half_sizes, predicted_joints
from kinmo.scans.poses.scan_estimate import PartPoses, Poses, ScanEstimate

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Points = tuple[F64, F64, I64]
"""NPCS and input points [n, 3] of all P parts of some scans, one part after the other, and the offsets [P + 1] of the parts."""
Ties = tuple[NDArray[np.uint32], NDArray[np.uint8], F64]
"""Joints between these parts: pairs [J, 2] of parent and part, codes of the kinds [J], and directions in NAOCS [J, 3]."""

PAIR_HYPOTHESES = 200
"""RANSAC hypotheses of each joint, for `PoseOptions.ties` = `pairs`."""


@dataclass(frozen=True)
class PoseOptions:
    """Options of `estimate_poses`.

    Attributes:
        hypotheses: RANSAC hypotheses of each part.
        ties: Joint constraints: on all parts at once (`tree`), or joint by joint as in ANCSH's release (`pairs`).
        boxes: Amodal boxes as `predicted`, or `fitted` to the sides that the scan shows.
        seed: Seed of RANSAC.
    """

    hypotheses: int = 10_000
    ties: Literal["tree", "pairs"] = "tree"
    boxes: Literal["fitted", "predicted"] = "fitted"
    seed: int = 0


def estimate_poses(
    predictions: Sequence[PointPredictions], structure: Structure, options: PoseOptions, prior: CategoryPrior | None = None
) -> list[ScanEstimate]:
    """Estimate part poses, amodal boxes and joints of some scans, each independently of the others.

    RANSAC fits each part alone. Votes give the joints. Then the poses are fitted again, constrained by the joints. The category
    prior constrains them too if `options.ties` is `tree`.
    """
    if not predictions:
        return []
    count, is_tree = structure.part_count, options.ties == "tree"
    if prior is None or not is_tree:
        prior = CategoryPrior.uninformative(structure)
    clouds = [each.on_part(part) for each in predictions for part in range(count)]
    source, target = (np.concatenate([cloud[place] for cloud in clouds]) for place in (0, 1))
    offsets = np.cumsum([0, *(len(npcs) for npcs, _ in clouds)], dtype=np.int64)
    points = source, target, offsets
    free, fits = _core.find_similarities(*points, hypotheses=options.hypotheses, threshold=MAX_MISFIT, seed=options.seed)
    spans = zip(np.isfinite(free[1]), pairwise(offsets), strict=True)
    inliers = np.array([fits[start:end].mean() if found else np.nan for found, (start, end) in spans])
    voted = [predicted_joints(each, structure) for each in predictions]
    directions = snap_directions(predictions, [own for own, _ in voted], free, structure, prior)
    ties = _ties(free, directions, structure)
    tied = _fit_trees(points, free, ties, prior) if is_tree else _fit_pairs(points, free, ties, options.seed)
    centers, half_extents = (_fitted_boxes if options.boxes == "fitted" else _predicted_boxes)(predictions, tied)
    estimates = []
    for row, each in enumerate(predictions):
        own, frame = slice(row * count, (row + 1) * count), each.frame
        rotations, scales, translations = (values[own] for values in tied)
        poses = PartPoses(frame.undo_rotations(rotations), scales / frame.scale, frame.undo(translations))
        joints = _estimate_joints(poses, each, (directions[row], voted[row][1]), structure, prior, average_pivots=is_tree)
        boxes = frame.undo(centers[own]), half_extents[own] / frame.scale
        estimates.append(ScanEstimate(poses, *boxes, inliers[own], *joints))
    return estimates


def _ties(free: Poses, directions: Sequence[F64], structure: Structure) -> Ties:
    """Joints with known directions whose two parts were found."""
    first = structure.part_count * np.arange(len(directions))[:, None]
    parents, parts = np.array(structure.parents, np.int64), np.arange(1, structure.part_count)
    pairs, axes = np.stack([first + parents, first + parts], axis=-1), np.stack(directions)
    kinds = np.tile(np.array([kind.code for kind in structure.kinds], np.uint8), (len(directions), 1))
    is_known = np.isfinite(axes).all(axis=-1) & np.isfinite(free[1])[pairs].all(axis=-1)
    return pairs[is_known].astype(np.uint32), kinds[is_known], axes[is_known]


def _fit_trees(points: Points, free: Poses, ties: Ties, prior: CategoryPrior) -> Poses:
    """Poses that agree with all joints of their scan and with the prior."""
    rotations, scales, translations = (values.copy() for values in free)
    # Parts that were not found get a placeholder pose, which constrains nothing, and stay NaN.
    lost = ~np.isfinite(scales)
    rotations[lost], scales[lost], translations[lost] = np.eye(3), 1.0, 0.0
    count = len(prior.axis_aligned)
    frames = np.arange(0, len(scales) + 1, count, dtype=np.int64)
    tied = _core.fit_constrained_poses(*points, *ties, rotations, scales, translations, frames=frames, threshold=MAX_MISFIT)
    turn_ranges = prior.turn_ranges[ties[0][:, 1] % count - 1]
    is_aligned = np.tile(prior.axis_aligned, len(frames) - 1) & ~lost
    tied = _core.refine_poses(*points, *ties, turn_ranges, is_aligned, *tied, frames=frames, threshold=MAX_MISFIT)
    for values in tied:
        values[lost] = np.nan
    return tied


def _fit_pairs(points: Points, free: Poses, ties: Ties, seed: int) -> Poses:
    """Poses that agree with one joint each. As in the release, the first joint of a part decides its pose."""
    rotations, scales, translations = (values.copy() for values in free)
    known = np.where(np.isfinite(scales), scales, 1.0)
    both = _core.find_constrained_poses(*points, *ties, known, hypotheses=PAIR_HYPOTHESES, threshold=MAX_MISFIT, seed=seed)
    placed: set[int] = set()
    for row, pair in enumerate(ties[0].tolist()):
        for part, fitted in zip(pair, both, strict=True):
            if part not in placed and np.isfinite(fitted[1][row]):
                rotations[part], translations[part] = fitted[0][row], fitted[2][row]
                placed.add(part)
    return rotations, scales, translations


def _predicted_boxes(predictions: Sequence[PointPredictions], poses: Poses) -> tuple[F64, F64]:
    """Centers and half extents [P, 3] of the predicted amodal boxes in the input frame."""
    rotations, scales, translations = poses
    half_extents = np.concatenate([predicted_half_sizes(each) for each in predictions]) * scales[:, None]
    return np.einsum("p,pij,j->pi", scales, rotations, MIDDLE) + translations, half_extents


def _fitted_boxes(predictions: Sequence[PointPredictions], poses: Poses) -> tuple[F64, F64]:
    """The predicted boxes with their visible sides moved to where the scan shows them (`_core.adjust_amodal_boxes`)."""
    centers, half_extents = _predicted_boxes(predictions, poses)
    is_known = np.asarray(np.isfinite(centers).all(axis=1) & np.isfinite(half_extents).all(axis=1))
    count = len(centers) // len(predictions)
    rows = [slice(frame * count, (frame + 1) * count) for frame in range(len(predictions))]
    owners = [_owners(each, [of[row] for of in poses]) for each, row in zip(predictions, rows, strict=True)]
    moved, _, fitted = _core.adjust_amodal_boxes(
        np.concatenate([each.points for each in predictions]),
        np.cumsum([0, *(len(each.points) for each in predictions)], dtype=np.int64),
        np.concatenate(owners),
        np.stack([each.frame.apply(np.zeros(3)).astype(np.float64) for each in predictions]),
        np.where(is_known[:, None], centers, 0.0),
        np.where(is_known[:, None, None], np.swapaxes(poses[0], 1, 2), np.eye(3)),
        np.where(is_known[:, None], half_extents, 0.0),
        frames=np.arange(len(predictions) + 1, dtype=np.int64) * count,
    )
    return np.where(is_known[:, None], moved, centers), np.where(is_known[:, None], fitted, half_extents)


def _owners(predictions: PointPredictions, poses: Sequence[F64]) -> I64:
    """Part [n] of each point; -1 for a point that does not fit the pose of its part."""
    rotations, scales, translations = poses
    part = np.maximum(predictions.parts, 0)
    places = scales[part, None] * np.einsum("nij,nj->ni", rotations[part], predictions.npcs) + translations[part]
    fits = (predictions.parts >= 0) & (np.linalg.norm(places - predictions.points, axis=1) < MAX_MISFIT)
    return np.where(fits, predictions.parts, -1)


def _estimate_joints(
    poses: PartPoses,
    predictions: PointPredictions,
    axes: tuple[F64, F64],
    structure: Structure,
    prior: CategoryPrior,
    *,
    average_pivots: bool,
) -> tuple[F64, F64, F64, F64]:
    """Directions, pivots [K - 1, 3], states and turns [K - 1] of the joints, as in `ScanEstimate`.

    The pose of the parent turns the `axes`, directions and pivots [K - 1, 3] in NAOCS, and places their pivots.
    `average_pivots` averages the pivots that both parts of a joint give. Usual ranges fix the number of whole turns.
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
            turn = _with_usual_turns(turn, prior.turn_ranges[row])
            states[row] = turn if kind is JointKind.REVOLUTE else _slide(poses, part, parent, direction, predictions)
            turns[row] = turn if kind is JointKind.SCREW else np.nan
    return directions, pivots, states, turns


def _slide(poses: PartPoses, part: int, parent: int, direction: F64, predictions: PointPredictions) -> float:
    """Displacement along the axis: from where the parent would have carried the part's middle to where that is."""
    middle = predictions.part_scales[part] * MIDDLE + predictions.part_shifts[part]
    carried = poses.apply(parent, predictions.to_npcs(parent, middle))
    return float((poses.apply(part, MIDDLE) - carried) @ (poses.rotations[parent] @ direction))


def _with_usual_turns(turn: float, usual: F64) -> float:
    """Add whole turns to an angle (rad) to bring it nearest to the middle of a range [2]; NaN ranges change nothing."""
    middle = usual.mean()
    return turn + 2.0 * np.pi * round((middle - turn) / (2.0 * np.pi)) if np.isfinite(middle) else turn


def turn_about(rotation: F64, direction: F64) -> float:
    """Angle in (-pi, pi] about the unit vector `direction` [3] that comes nearest to `rotation` [3, 3]."""
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(np.pi - (np.pi - 2.0 * np.arctan2(np.dot([x, y, z], direction), w)) % (2.0 * np.pi))
