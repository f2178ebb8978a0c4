"""Outliers of a scan: points far from all others, which depth cameras see between near and far surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

F64 = NDArray[np.float64]

LINK_SHARE = 0.1
"""Largest distance between neighbours of one cluster, as a share of the diagonal of the visible points."""
LINK_SPACINGS = 3.0
"""The same distance in median spacings of the points; it counts where points are few."""
MIN_POINTS = 64
"""Number of points from which on outliers can be told from others."""
MAX_OUTLIERS, MAX_OUTLIER_SHARE = 2, 0.005
"""Largest cluster of outliers: number of points, or share of all points."""
MARGIN = 0.25
"""Distance of outliers from the box of the larger clusters, as a share of its diagonal. The edge of an open door may be a
cluster of few points, but it is nearly always nearer. Nearer outliers hardly change the networks' predictions."""


def find_outliers(points: NDArray[np.floating], sample: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Mask [n] of the outliers among points [n, 3].

    Outliers lie outside the box of all clusters that are too large to be outliers, by `MARGIN` or more. The box comes from a
    `sample` [m, 3] of the points; a thousand are enough.
    """
    low, high = _inlier_box(np.unique(np.asarray(sample, np.float64), axis=0))
    return np.asarray(((points < low) | (points > high)).any(axis=1))


def _inlier_box(points: F64) -> tuple[F64, F64]:
    """Corners [3] of the box outside which all points are outliers, from distinct points [n, 3]."""
    if len(points) < MIN_POINTS:
        return np.full(3, -np.inf), np.full(3, np.inf)
    low, high = np.quantile(points, [0.05, 0.95], axis=0)
    tree = cKDTree(points)
    spacing = float(np.median(tree.query(points, k=2)[0][:, 1]))
    link = max(LINK_SHARE * float(np.linalg.norm(high - low)), LINK_SPACINGS * spacing)
    pairs = tree.query_pairs(link, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, cluster = connected_components(links, directed=False)
    sizes = np.bincount(cluster)
    kept = points[(sizes > max(MAX_OUTLIERS, MAX_OUTLIER_SHARE * len(points)))[cluster]]
    if not len(kept):
        return np.full(3, -np.inf), np.full(3, np.inf)
    low, high = kept.min(axis=0), kept.max(axis=0)
    margin = MARGIN * float(np.linalg.norm(high - low))
    return low - margin, high + margin
