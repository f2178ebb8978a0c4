"""Pose fitting: from point predictions to part poses, amodal boxes, joints and joint states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.amodal_boxes import Poses, fitted_boxes, predicted_boxes
from kinmo.scans.poses.axis_snapping import snap_directions
from kinmo.scans.poses.category_prior import CategoryPrior
from kinmo.scans.poses.joint_estimates import estimate_joints
from kinmo.scans.poses.point_predictions import PointPredictions, predicted_joints
from kinmo.scans.poses.scan_estimate import PartPoses, ScanEstimate
from kinmo.scans.preprocessing.input_frame import InputFrame

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


@dataclass(frozen=True)
class PoseOptions:
    """Options of `estimate_poses`.

    Attributes:
        hypotheses: RANSAC hypotheses of each part.
        threshold: Largest distance of a point that fits, in the input frame, where the object or its visible part has the
            diagonal 1.
        ties: Joint constraints: on all parts at once (`tree`), joint by joint as in ANCSH's release (`pairs`), or none.
        pair_hypotheses: RANSAC hypotheses of each joint, for `pairs`.
        boxes: Amodal boxes as `predicted`, or `fitted` to the sides that the scan shows.
        seed: Seed of RANSAC.
    """

    hypotheses: int = 10_000
    threshold: float = 0.1
    ties: Literal["tree", "pairs", "none"] = "tree"
    pair_hypotheses: int = 200
    boxes: Literal["fitted", "predicted"] = "fitted"
    seed: int = 0


def estimate_poses(
    predictions: Sequence[PointPredictions],
    structure: Structure,
    options: PoseOptions,
    prior: CategoryPrior | None = None,
) -> list[ScanEstimate]:
    """Estimate part poses, amodal boxes and joints of some scans (ANCSH, Li 2020, section 4.3).

    RANSAC fits each part alone. Votes give the joints. Then the poses are fitted again, constrained by the joints.

    Args:
        predictions: Predictions for F scans.
        structure: Structure of the objects, with K parts.
        options: Options of the fitting.
        prior: Category prior; it constrains the poses if `options.ties` is `tree`.

    Returns:
        One estimate per scan, independent of the other scans.
    """
    if not predictions:
        return []
    count = structure.part_count
    if prior is None or options.ties != "tree":
        prior = CategoryPrior.uninformative(structure)
    clouds = [each.on_part(part) for each in predictions for part in range(count)]
    source, target = (np.concatenate([cloud[place] for cloud in clouds]) for place in (0, 1))
    offsets = np.cumsum([0, *(len(npcs) for npcs, _ in clouds)], dtype=np.int64)
    free, fits = _core.find_similarities(
        source, target, offsets, hypotheses=options.hypotheses, threshold=options.threshold, seed=options.seed
    )
    was_found = np.isfinite(free[1])
    inliers = np.array(
        [fits[a:b].mean() if found else np.nan for found, (a, b) in zip(was_found, pairwise(offsets), strict=True)]
    )
    voted = [predicted_joints(each, structure) for each in predictions]
    directions = snap_directions(predictions, [own for own, _ in voted], free, structure, prior, options.threshold)
    tied = _fit_constrained_poses(free, source, target, offsets, directions, structure, options, prior)
    if options.boxes == "fitted":
        centers, half_extents = fitted_boxes(predictions, tied, options.threshold)
    else:
        centers, half_extents = predicted_boxes(predictions, tied)
    estimates = []
    for row, each in enumerate(predictions):
        own, frame = slice(row * count, (row + 1) * count), each.frame
        poses = _in_camera(frame, *(values[own] for values in tied))
        axes, is_tree = (directions[row], voted[row][1]), options.ties == "tree"
        joints = estimate_joints(poses, each, axes, structure, prior, average_pivots=is_tree)
        boxes = frame.undo(centers[own]), half_extents[own] / frame.scale
        estimates.append(ScanEstimate(poses, *boxes, inliers[own], *joints))
    return estimates


def _in_camera(frame: InputFrame, rotations: F64, scales: F64, translations: F64) -> PartPoses:
    return PartPoses(frame.undo_rotations(rotations), scales / frame.scale, frame.undo(translations))


def _fit_constrained_poses(
    free: Poses,
    source: F64,
    target: F64,
    offsets: I64,
    directions: Sequence[F64],
    structure: Structure,
    options: PoseOptions,
    prior: CategoryPrior,
) -> Poses:
    """Poses that agree with the joints, for parts that were found and are tied by joints with known directions."""
    if options.ties == "none":
        return free
    count = structure.part_count
    pairs, kinds, axes, turn_ranges = [], [], [], []
    for frame, own in enumerate(directions):
        for part, (kind, parent) in enumerate(zip(structure.kinds, structure.parents, strict=True), start=1):
            two = (frame * count + parent, frame * count + part)
            if np.isfinite(own[part - 1]).all() and np.isfinite(free[1][list(two)]).all():
                pairs.append(two)
                kinds.append(kind.code)
                axes.append(own[part - 1])
                turn_ranges.append(prior.turn_ranges[part - 1])
    ties = np.array(pairs, np.uint32).reshape(-1, 2), np.array(kinds, np.uint8), np.array(axes).reshape(-1, 3)
    rotations, scales, translations = (values.copy() for values in free)
    if options.ties == "tree":
        # Parts that were not found get a placeholder pose, which constrains nothing, and stay NaN.
        lost = ~np.isfinite(scales)
        rotations[lost], scales[lost], translations[lost] = np.eye(3), 1.0, 0.0
        frames = np.arange(len(directions) + 1, dtype=np.int64) * count
        tied = _core.fit_constrained_poses(
            source, target, offsets, *ties, rotations, scales, translations, frames=frames, threshold=options.threshold
        )
        tied = _core.refine_poses(
            source, target, offsets, *ties, np.array(turn_ranges).reshape(-1, 2),
            np.tile(prior.axis_aligned, len(directions)) & ~lost, *tied, frames=frames, threshold=options.threshold,
        )  # fmt: skip
        for values in tied:
            values[lost] = np.nan
        return tied
    known = np.where(np.isfinite(scales), scales, 1.0)
    both = _core.find_constrained_poses(
        source,
        target,
        offsets,
        *ties,
        known,
        hypotheses=options.pair_hypotheses,
        threshold=options.threshold,
        seed=options.seed,
    )
    placed: set[int] = set()
    for row, two in enumerate(pairs):
        for place, part in enumerate(two):
            # As in the release, the first joint of a part decides its pose.
            if part not in placed and np.isfinite(both[place][1][row]):
                rotations[part], translations[part] = both[place][0][row], both[place][2][row]
                placed.add(part)
    return rotations, scales, translations
