"""Interaction region of a movable part and its reference part (Hu et al. 2015; paper, section 3.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.paper.leaf_roles import LeafRoles

REGION_SAMPLES = 128
"""Surface samples per leaf that interaction regions are computed from."""


def interaction_centroid(shape: PreparedShape, roles: LeafRoles) -> NDArray[np.float64] | None:
    """Centroid [3] of the interaction region: the second pivot of axes in the central region of a part (paper, section 3.3).

    It is in the normalised frame, and None if the part has no leaves or no reference.
    """
    if not roles.reference or not roles.own:
        return None
    points = np.ascontiguousarray(shape.leaf_points[:, :REGION_SAMPLES])
    regions = _core.interaction_regions(points, np.array([[0, 1]], np.uint32), [roles.own, roles.reference])
    return np.asarray(regions.centroids[0])
