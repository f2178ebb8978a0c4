"""Motion types predicted by the motion GNN, as a prior for ranked candidate joints.

The ranking networks see features of candidate joints that do not change when the object turns about up. The motion GNN sees
points and the hierarchy along the axes of the file. The two make different errors, above all where few shapes are annotated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, Joint
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.oriented_box import Box
from kinmo.core.shape_estimate import JointEstimate
from kinmo.core.vector import Vector
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_estimate import gnn_joint, mean_estimate
from kinmo.methods.kinmo.ranking.name_words import maximal_nodes

F64 = NDArray[np.float64]

PRIOR_POWER = 0.5
"""Power of the GNN's type probabilities; below 1 because the ranking networks are right more often."""
MIN_TYPE_PROBABILITY = 0.005
"""Added to every type probability, so that a body predicted as FIXED has no preferred motion type."""
MOTION_TYPES = int(MotionType.FIXED)
"""Number of motion types of parts that move."""


def outward_edges(shape: PreparedShape, leaves: Sequence[int]) -> NDArray[np.int64]:
    """Indices of the edges from the parts of a body (positions of its leaves) to siblings outside it."""
    is_own = np.isin(shape.edges, maximal_nodes(shape, leaves))
    return np.flatnonzero(is_own[:, 0] & ~is_own[:, 1])


def motion_type_probabilities(shape: PreparedShape, leaves: Sequence[int], edges: EdgePredictions) -> F64 | None:
    """The GNN's probabilities [8] of the motion types of a body, given that it moves; None without an edge to a sibling."""
    outward = outward_edges(shape, leaves)
    if not len(outward):
        return None
    probabilities = mean_estimate(edges, outward).probabilities[:MOTION_TYPES] + MIN_TYPE_PROBABILITY
    return np.asarray(probabilities / probabilities.sum(), np.float64)


def apply_gnn_prior(
    probabilities: F64, types: F64 | None, features: CandidateFeatures, group: int, box: Box, up: Vector
) -> F64:
    """Probabilities [C] of a group's candidate joints, weighted by the GNN's probabilities of their motion types.

    The total probability of each joint kind stays the same, because the ranking networks predict kinds more reliably. `types`
    [8] are the probabilities of the motion types; None leaves the probabilities as they are. The type of a candidate depends on
    the symmetry-aligned box of the group and on the unit vector `up`.
    """
    if types is None:
        return probabilities
    rows = features.rows(group)
    kinds = features.kinds[rows]
    motions = zip(kinds.tolist(), features.directions[rows], features.pivots[rows], strict=True)
    prior = [types[motion_type(Joint(KINDS[kind], direction, pivot), box, up)] for kind, direction, pivot in motions]
    weighted = probabilities * np.power(prior, PRIOR_POWER)
    for kind in np.unique(kinds):
        own = kinds == kind
        if weighted[own].any():
            weighted[own] *= probabilities[own].sum() / weighted[own].sum()
    return np.asarray(weighted)


def gnn_estimates(shape: PreparedShape, bodies: Sequence[tuple[int, ...]], edges: EdgePredictions) -> list[JointEstimate]:
    """The joint that the motion GNN alone predicts for every body (positions of its leaves), in the normalised frame."""
    outward = [outward_edges(shape, leaves) for leaves in bodies]
    return [gnn_joint(mean_estimate(edges, own) if len(own) else None) for own in outward]
