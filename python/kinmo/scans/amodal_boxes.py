"""The amodal boxes of parts: what is said of them, brought into line with what a scan shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.scans.point_predictions import MIDDLE, PointAnswers, said_half_sizes

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]
Poses = tuple[F64, F64, F64]
"""Rotations [P, 3, 3], scales [P] and translations [P, 3] of all parts of some scans, one scan after the other, that take NPCS
to what networks see; NaN for parts that were not found."""


def said_boxes(answers: Sequence[PointAnswers], poses: Poses) -> tuple[F64, F64]:
    """Centers and half extents [P, 3] as networks see them, of boxes whose middles are at `MIDDLE` of NPCS."""
    rotations, scales, translations = poses
    half_extents = np.concatenate([said_half_sizes(answer) for answer in answers]) * scales[:, None]
    return np.einsum("p,pij,j->pi", scales, rotations, MIDDLE) + translations, half_extents


def seen_boxes(answers: Sequence[PointAnswers], poses: Poses, threshold: float) -> tuple[F64, F64]:
    """As `said_boxes`, with their sides where the scan shows them (`_core.seen_boxes`).

    A point is one of a part where what is said of it is within `threshold` of where it is.
    """
    centers, half_extents = said_boxes(answers, poses)
    is_known = np.asarray(np.isfinite(centers).all(axis=1) & np.isfinite(half_extents).all(axis=1))
    count = len(centers) // len(answers)
    rows = [slice(frame * count, (frame + 1) * count) for frame in range(len(answers))]
    owners = [_owners(answer, [of[row] for of in poses], threshold) for answer, row in zip(answers, rows, strict=True)]
    moved, _, seen = _core.seen_boxes(
        np.concatenate([answer.points for answer in answers]),
        np.cumsum([0, *(len(answer.points) for answer in answers)], dtype=np.int64),
        np.concatenate(owners),
        np.stack([answer.frame.apply(np.zeros(3)).astype(np.float64) for answer in answers]),
        np.where(is_known[:, None], centers, 0.0),
        np.where(is_known[:, None, None], np.swapaxes(poses[0], 1, 2), np.eye(3)),
        np.where(is_known[:, None], half_extents, 0.0),
        frames=np.arange(len(answers) + 1, dtype=np.int64) * count,
    )
    return np.where(is_known[:, None], moved, centers), np.where(is_known[:, None], seen, half_extents)


def _owners(answer: PointAnswers, poses: Sequence[F64], threshold: float) -> I64:
    """The part [n] of every point, -1 for one that is not where its part is."""
    rotations, scales, translations = poses
    part = np.maximum(answer.parts, 0)
    places = scales[part, None] * np.einsum("nij,nj->ni", rotations[part], answer.npcs) + translations[part]
    fits = (answer.parts >= 0) & (np.linalg.norm(places - answer.points, axis=1) < threshold)
    return np.where(fits, answer.parts, -1)
