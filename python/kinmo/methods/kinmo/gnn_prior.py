"""What the motion GNN says of hypotheses that were ranked: two networks that see a shape in different ways know more than one.

The ranking sees numbers about every motion, which are the same however the shape is turned about up; the GNN sees points and
the hierarchy, along the axes of the file. Where few shapes of a kind are annotated, what one has not learnt the other often
has.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import Box
from kinmo.core.edge_labels import motion_type
from kinmo.core.joint import KINDS, Joint, MotionType
from kinmo.core.vector import Vector
from kinmo.features.candidate_features import Evidence
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_estimate import mean_estimate
from kinmo.methods.kinmo.ranking.shape_views import maximal_nodes

F64 = NDArray[np.float64]

SAY = 0.5
"""The power of the GNN's probabilities beside those of the ranking, which is several networks, and right more often."""
LEAST = 0.005
"""Added to the probability of every type of motion: to what the GNN holds to be fixed all of them are alike."""
MOTIONS = len([kind for kind in MotionType if kind.kind is not None])


def outward_edges(shape: PreparedShape, leaves: Sequence[int]) -> NDArray[np.int64]:
    """Indices of the edges from the parts of a body (positions of its leaves) to siblings outside it."""
    is_own = np.isin(shape.edges, maximal_nodes(shape, leaves))
    return np.flatnonzero(is_own[:, 0] & ~is_own[:, 1])


def motion_types_of(shape: PreparedShape, leaves: Sequence[int], edges: EdgePredictions) -> F64 | None:
    """The GNN's probabilities [8] of the types of motion of a body, if it moves; None for one without an edge to a sibling."""
    outwards = outward_edges(shape, leaves)
    if not len(outwards):
        return None
    said = mean_estimate(edges, outwards).probabilities[:MOTIONS] + LEAST
    return np.asarray(said / said.sum(), np.float64)


def with_types(odds: F64, types: F64 | None, evidence: Evidence, unit: int, box: Box, up: Vector) -> F64:
    """Probabilities [h] of the hypotheses of a unit, those of its types of motion [8] taken into account.

    How likely it is to turn, to slide, or to do both stays as it is: of that the ranking knows more. The types depend on `box`,
    the unit's, and `up`.
    """
    if types is None:
        return odds
    rows = evidence.rows(unit)
    kinds = evidence.kinds[rows]
    motions = zip(kinds.tolist(), evidence.directions[rows], evidence.pivots[rows], strict=True)
    said = [types[motion_type(Joint(KINDS[kind], direction, pivot), box, up)] for kind, direction, pivot in motions]
    both = odds * np.power(said, SAY)
    for kind in np.unique(kinds):
        own = kinds == kind
        if both[own].any():
            both[own] *= odds[own].sum() / both[own].sum()
    return np.asarray(both)
