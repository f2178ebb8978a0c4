"""Points of a scan that lie far from all others: what a depth camera sees where it is unsure, between near and far."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

F64 = NDArray[np.float64]

LINK = 0.1
"""Share of the diagonal of what is seen that points of one piece are from the next at most..."""
SPARSE = 3.0
"""...or this many times as far as the usual point is from the nearest other, where points are few."""
LEAST = 64
"""Among fewer points nothing tells a stray from another."""
FEW, SHARE = 2, 0.005
"""Points of a piece, and share of all, that may be strays."""
AWAY = 0.25
"""Share of the diagonal of the other pieces' box that strays are outside of it. The edge of an open door, of which no more may
be seen, is nearer in nearly all scans; and what is nearer than this hardly changes what networks say."""


def are_strays(points: NDArray[np.floating], some: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Which of the points of a scan [n, 3] are strays, [n], as `some` of them [m, 3] tell: a thousand do.

    It is those outside of the box of all pieces that have too many points to be strays themselves, by `AWAY` or more.
    """
    low, high = _box_without_strays(np.unique(np.asarray(some, np.float64), axis=0))
    return np.asarray(((points < low) | (points > high)).any(axis=1))


def _box_without_strays(points: F64) -> tuple[F64, F64]:
    """The corners [3] of a box outside of which all is stray, from points [n, 3], no two at one place."""
    if len(points) < LEAST:
        return np.full(3, -np.inf), np.full(3, np.inf)
    low, high = np.quantile(points, [0.05, 0.95], axis=0)
    tree = cKDTree(points)
    spacing = float(np.median(tree.query(points, k=2)[0][:, 1]))
    pairs = tree.query_pairs(max(LINK * float(np.linalg.norm(high - low)), SPARSE * spacing), output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, piece = connected_components(links, directed=False)
    sizes = np.bincount(piece)
    kept = points[(sizes > max(FEW, SHARE * len(points)))[piece]]
    if not len(kept):
        return np.full(3, -np.inf), np.full(3, np.inf)
    low, high = kept.min(axis=0), kept.max(axis=0)
    margin = AWAY * float(np.linalg.norm(high - low))
    return low - margin, high + margin
