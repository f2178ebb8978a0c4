"""Which body of a prediction is which part of the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from kinmo.evaluation.urdf_scoring.sampled_surface import Surface

REACH = 0.01
"""In diagonals: a point farther than this from a surface does not lie on it."""
SHARED = 5e-4
"""In diagonals: surfaces this close behind the nearest one own the point too."""
LEAST_IOU = 0.5


@dataclass(frozen=True, eq=False)
class Match:
    """`iou` [K, B] of K true parts and B bodies, `body_of` the body of every matched part.

    `home` is the body that holds most of each part's surface, None where no body holds any.
    """

    iou: NDArray[np.float64]
    body_of: dict[int, int]
    home: tuple[int | None, ...]


def match(
    parts: Sequence[Surface], junk: NDArray[np.bool_], bodies: Sequence[Surface], diagonal: float, least_iou: float
) -> Match:
    """Match K parts, of which some are junk [K], to bodies in the same frame by the overlap of their surfaces.

    With r the share of a part that lies on a body, and p the share of the body that lies on the part (what lies on junk or on
    nothing is left out), the overlap is rp / (r + p - rp), the intersection over union of two sets with these shares.
    """
    recall, _ = shares_on(parts, bodies, diagonal)
    precision, on_any = shares_on(bodies, parts, diagonal)
    judged = np.maximum(on_any - precision[:, junk].sum(axis=1), 1e-9)
    precision = np.clip(precision / judged[:, None], 0.0, 1.0).T
    shared = recall * precision
    iou = np.divide(shared, recall + precision - shared, out=np.zeros_like(shared), where=shared > 0)
    iou[junk] = 0.0
    wanted = np.where(iou >= least_iou, iou, 0.0)
    pairs = zip(*linear_sum_assignment(wanted, maximize=True), strict=True)
    home = tuple(int(row.argmax()) if row.max() > 0 else None for row in recall)
    return Match(iou, {int(part): int(body) for part, body in pairs if wanted[part, body] > 0}, home)


def shares_on(
    sources: Sequence[Surface], targets: Sequence[Surface], diagonal: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The share [S, T] of every source's surface that lies on each target, and the share [S] that lies on any."""
    shares, on_any = np.zeros((len(sources), len(targets))), np.zeros(len(sources))
    for index, source in enumerate(sources):
        distances = np.stack([target.distances_within(source.points, REACH * diagonal) for target in targets], axis=1)
        nearest = distances.min(axis=1, keepdims=True)
        on_some = nearest <= REACH * diagonal
        shares[index] = ((distances <= nearest + SHARED * diagonal) & on_some).mean(axis=0)
        on_any[index] = on_some.mean()
    return shares, on_any
