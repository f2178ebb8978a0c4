"""Nodes of the hierarchy that move relative to their surroundings, by the ranking networks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.gnn_prior import apply_gnn_prior, motion_type_probabilities
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.ranked_joints import MIN_REST_PROBABILITY, rank_joints, same_joint
from kinmo.methods.kinmo.ranking.shape_views import node_view

MIN_MISSED_AREA = 0.03
"""Least share of the shape's surface of a missed part; a missed pin or button spoils no pseudo label."""


@dataclass(frozen=True, eq=False)
class MovingNodes:
    """Nodes of the hierarchy that are predicted to move.

    Attributes:
        moving: The best joint of every moving node, in the normalised frame.
        missed_motion_probability: Largest probability that a large node moves although it is predicted to rest. Nodes inside,
            above or equal to a moving node do not count.
    """

    moving: Mapping[int, Joint]
    missed_motion_probability: float


def find_moving_nodes(shape: PreparedShape, ranker: JointRanker, edges: EdgePredictions) -> MovingNodes:
    """Nodes that move relative to their surroundings; the annotation of the shape is not used.

    The ranking networks alone decide whether a node moves; the motion GNN is a prior for its joint. A node with the same joint
    as a moving node above it moves along with that node.
    """
    if len(shape.parents) < 2:
        return MovingNodes({}, 0.0)
    features = CandidateFeatures.of(shape.candidate_features)
    view = node_view(replace(shape, mobility=None), features)
    ranked, rest = ranker.probabilities(view)
    moving: dict[int, Joint] = {}
    for node, (group, probabilities, still) in enumerate(zip(view.groups, ranked, rest, strict=True), start=1):
        if still < MIN_REST_PROBABILITY:
            box = shape.symmetric_boxes[node]
            types = motion_type_probabilities(shape, shape.leaves_below[node], edges)
            probabilities = apply_gnn_prior(probabilities, types, features, group, box, shape.up)
            best = rank_joints(features, group, probabilities, float(still), box, shape.up)[0].joint
            assert best is not None, "a node that moves has a joint"
            above = next((other for other in _ancestors(shape, node) if other in moving), None)
            if above is None or not same_joint(moving[above], best):
                moving[node] = best
    return MovingNodes(moving, _missed_motion_probability(shape, moving, rest))


def _missed_motion_probability(shape: PreparedShape, moving: Mapping[int, Joint], rest: NDArray[np.float64]) -> float:
    excluded = {other for node in moving for other in (node, *_ancestors(shape, node))}
    min_area = MIN_MISSED_AREA * shape.leaf_areas.sum()
    missed = [
        1.0 - float(rest[node - 1])
        for node in range(1, len(shape.parents))
        if node not in excluded
        and moving.keys().isdisjoint(_ancestors(shape, node))
        and shape.leaf_areas[list(shape.leaves_below[node])].sum() >= min_area
    ]
    return max(missed, default=0.0)


def _ancestors(shape: PreparedShape, node: int) -> Iterator[int]:
    """The nodes above a node, the nearest first."""
    while (node := shape.parents[node]) >= 0:
        yield node
