"""Symmetry-aligned boxes of any leaves of a prepared shape (Fish et al. 2014; paper, section 3.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kinmo import _core
from kinmo.core.oriented_box import Box
from kinmo.features.prepared_shape import PreparedShape


def symmetric_box(shape: PreparedShape, leaves: Sequence[int], meshes: _core.Meshes | None = None) -> Box:
    """Symmetry-aligned box of some leaves: the stored one if they form a part or a body, a fitted one otherwise.

    It is fitted to `meshes` of all leaves in the normalised frame, or without them to the convex hull of the samples.
    """
    wanted = tuple(sorted(leaves))
    for stored, boxes in ((shape.leaves_below, shape.symmetric_boxes), (shape.body_leaves, shape.body_boxes)):
        if boxes is not None and wanted in stored:
            return boxes[stored.index(wanted)]
    surface, groups = (_hull(shape, wanted), None) if meshes is None else (meshes, [list(wanted)])
    centers, axes, half_extents = _core.fit_symmetric_boxes(surface, groups)[:3]
    return Box(centers[0], axes[0], half_extents[0])


def _hull(shape: PreparedShape, leaves: Sequence[int]) -> _core.Meshes:
    """Convex hull of the samples of some leaves, as one mesh."""
    points = shape.leaf_points[list(leaves)].reshape(-1, 3).astype(np.float64)
    try:
        faces = ConvexHull(points).simplices
    except QhullError:  # flat or thin: any triangles through all points have the same box
        faces = np.stack([np.zeros(len(points) - 2), np.arange(1, len(points) - 1), np.arange(2, len(points))], axis=1)
    return _core.Meshes([points], [np.ascontiguousarray(faces, np.uint32)])
