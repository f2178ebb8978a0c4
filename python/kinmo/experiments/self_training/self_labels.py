"""Labels for scans of which nothing is known, from what networks say of them (the paper's ANCSH (Semi))."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.scans.object_structure import Extents, Structure
from kinmo.scans.poses.point_predictions import MIDDLE, PointPredictions, predicted_half_sizes, predicted_joints
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.rendering.labelled_frames import LabelledFrames

F64 = NDArray[np.float64]

UNSURE = "networks were not sure of it"


@dataclass(frozen=True, eq=False)
class SaidObject:
    """What networks say of one object: its `joints` and the boxes of its parts in the normalised frame; no more is known."""

    id: str
    category: str
    structure: Structure
    joints: tuple[Joint, ...]
    part_extents: Extents

    @property
    def axis_aligned_shares(self) -> F64:
        """As in `ScanFile`: not known."""
        return np.full(self.structure.part_count, np.nan)


def is_sure(found: ScanEstimate, confidence: float) -> bool:
    """Whether every part was found, and at least the share `confidence` of the points of each agrees on where it is."""
    return bool(found.poses.found.all() and np.isfinite(found.directions).all() and found.inliers.min() >= confidence)


def self_labelled(
    name: tuple[str, str],
    points: NDArray[np.float32],
    answers: Sequence[PointPredictions],
    estimates: Sequence[ScanEstimate],
    structure: Structure,
    confidence: float,
) -> tuple[SaidObject, LabelledFrames] | None:
    """The frames of one object that networks are sure of, labelled; None where there is none.

    `name` is the object's id and category, `points` [F, n, 3] its scans in the camera's frame. Boxes and joints are the medians
    of what the frames say; a point's place on its part is where the part's pose, not the point alone, has it. The states of
    joints are not known (NaN), nor are poses as labelled scans have them.
    """
    sure = [row for row, found in enumerate(estimates) if is_sure(found, confidence)]
    if not sure:
        return None
    extents = _extents([answers[row] for row in sure])
    joints = _joints([answers[row] for row in sure], [estimates[row] for row in sure], structure)
    said = SaidObject(*name, structure, joints, extents)
    places = np.zeros((len(sure), *points.shape[1:]), np.float32)
    for frame, row in enumerate(sure):
        poses, parts = estimates[row].poses, answers[row].parts
        for part in range(structure.part_count):
            own = parts == part
            npcs = (points[row][own] - poses.translations[part]) @ poses.rotations[part] / poses.scales[part]
            places[frame, own] = (npcs - MIDDLE) * extents.diagonals[part] + extents.centers[part]
    count, parts_of = structure.part_count, np.stack([answers[row].parts for row in sure]).astype(np.int16)
    unknown = np.full((len(sure), count - 1), np.nan)
    refused = Counter({UNSURE: len(estimates) - len(sure)})
    poses_of = np.full((len(sure), count, 4, 4), np.nan)
    return said, LabelledFrames(points[sure], parts_of, places, poses_of, unknown, unknown.copy(), refused)


def _extents(answers: Sequence[PointPredictions]) -> Extents:
    """Boxes whose diagonals are the sizes of the parts in NAOCS, and whose proportions are those said."""
    scales = np.median([answer.part_scales for answer in answers], axis=0)
    shifts = np.median([answer.part_shifts for answer in answers], axis=0)
    shapes = np.median([predicted_half_sizes(answer) for answer in answers], axis=0)
    sizes = shapes / np.linalg.norm(shapes, axis=1, keepdims=True) * scales[:, None]
    return Extents(shifts + MIDDLE * scales[:, None] - MIDDLE, sizes)


def _joints(answers: Sequence[PointPredictions], estimates: Sequence[ScanEstimate], structure: Structure) -> tuple[Joint, ...]:
    """Pivots are medians of what is said; directions the lines that come nearest to those found, of the sign of most."""
    parents = list(structure.parents)
    found = [np.einsum("kji,kj->ki", each.poses.rotations[parents], each.directions) for each in estimates]
    directions = [_mean_direction(np.stack([frame[row] for frame in found])) for row in range(len(parents))]
    pivots = np.median([predicted_joints(answer, structure)[1] for answer in answers], axis=0)
    return tuple(
        Joint(kind, direction, pivot - MIDDLE)
        for kind, direction, pivot in zip(structure.kinds, directions, pivots, strict=True)
    )


def _mean_direction(directions: F64) -> F64:
    """The unit vector [3] along the line that unit vectors [n, 3] are nearest to, whatever their signs."""
    _, axes = np.linalg.eigh(directions.T @ directions)
    line = np.asarray(axes[:, -1])
    return -line if (directions @ line > 0.0).mean() < 0.5 else line
