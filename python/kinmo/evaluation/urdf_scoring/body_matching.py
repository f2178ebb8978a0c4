"""Matching of predicted bodies with the parts of the truth, by their sampled surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from kinmo.evaluation.urdf_scoring.sampled_surface import Surface

MAX_DISTANCE = 0.01
"""Largest distance of a point from a surface that it lies on, in diagonals."""
TIE_DISTANCE = 5e-4
"""A point also lies on surfaces that are at most this much farther than the nearest one, in diagonals."""
MIN_IOU = 0.5
"""Smallest overlap of a part and a body that match."""


@dataclass(frozen=True, eq=False)
class Match:
    """A matching of K true parts with B bodies.

    Attributes:
        iou: Overlaps [K, B].
        body_of: The body of every matched part.
        home: The body that holds most of each part's surface; None if no body holds any.
    """

    iou: NDArray[np.float64]
    body_of: dict[int, int]
    home: tuple[int | None, ...]


def match_parts(
    parts: Sequence[Surface], junk: NDArray[np.bool_], bodies: Sequence[Surface], diagonal: float, min_iou: float
) -> Match:
    """Match parts with bodies one to one, so that the total overlap of their surfaces is largest.

    Let r be the share of a part that lies on a body. Let p be the share of the body that lies on the part, without surface that
    lies on junk or on nothing. The overlap is rp / (r + p - rp), the intersection over union of two sets with these shares.

    Args:
        parts: Surfaces of the K true parts.
        junk: Mask [K] of the parts that are junk.
        bodies: Surfaces of the B bodies, in the same frame.
        diagonal: Diagonal of the true object.
        min_iou: Smallest overlap of a match.
    """
    recall, _ = surface_shares(parts, bodies, diagonal)
    precision, on_any = surface_shares(bodies, parts, diagonal)
    counted = np.maximum(on_any - precision[:, junk].sum(axis=1), 1e-9)
    precision = np.clip(precision / counted[:, None], 0.0, 1.0).T
    shared = recall * precision
    iou = np.divide(shared, recall + precision - shared, out=np.zeros_like(shared), where=shared > 0)
    iou[junk] = 0.0
    allowed = np.where(iou >= min_iou, iou, 0.0)
    pairs = zip(*linear_sum_assignment(allowed, maximize=True), strict=True)
    home = tuple(int(row.argmax()) if row.max() > 0 else None for row in recall)
    return Match(iou, {int(part): int(body) for part, body in pairs if allowed[part, body] > 0}, home)


def surface_shares(
    sources: Sequence[Surface], targets: Sequence[Surface], diagonal: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shares of S surfaces that lie on T other ones.

    Returns:
        The share [S, T] of each source on each target, and the share [S] of each source on any target.
    """
    shares, on_any = np.zeros((len(sources), len(targets))), np.zeros(len(sources))
    for index, source in enumerate(sources):
        distances = np.stack([target.distances_within(source.points, MAX_DISTANCE * diagonal) for target in targets], axis=1)
        nearest = distances.min(axis=1, keepdims=True)
        on_some = nearest <= MAX_DISTANCE * diagonal
        shares[index] = ((distances <= nearest + TIE_DISTANCE * diagonal) & on_some).mean(axis=0)
        on_any[index] = on_some.mean()
    return shares, on_any
