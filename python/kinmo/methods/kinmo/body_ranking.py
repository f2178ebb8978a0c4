"""Ranking of the candidate joints of bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import CandidateFeatures, compute_candidate_features
from kinmo.features.prepared_shape import PreparedShape, leaf_groups, part_sizes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.symmetric_box import symmetric_box
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.gnn_prior import apply_gnn_prior, motion_type_probabilities
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.name_words import category_words, group_words
from kinmo.methods.kinmo.ranking.ranked_joints import MIN_REST_PROBABILITY, rank_joints
from kinmo.methods.kinmo.ranking.shape_views import ShapeView

F64 = NDArray[np.float64]


def rank_bodies(
    shape: PreparedShape,
    meshes: _core.Meshes | None,
    bodies: Sequence[tuple[int, ...]],
    ranker: JointRanker,
    edges: EdgePredictions,
    *,
    may_rest: Literal["any", "first", "one"] = "any",
    kinds: Sequence[JointKind | None] | None = None,
) -> list[tuple[JointEstimate, ...]]:
    """Ranked joints of every body, best first, in the normalised frame and without limits.

    Args:
        shape: The prepared shape; its annotation is not used.
        meshes: Meshes of the leaves, in the normalised frame. Needed for bodies that the shape was not prepared with.
        bodies: Positions of the leaves of each body.
        ranker: Trained ranking networks.
        edges: Predictions of the motion GNN, a prior for the motion types.
        may_rest: Bodies that may rest. `any`: every body. `first`: the first body rests, all others move. If the first is
            empty, the body that most likely rests takes its place. `one`: only the body that most likely rests may rest. Bodies
            of one shape are attached to each other, so only one needs to rest.
        kinds: Known joint kinds; None for bodies whose kind is predicted.

    Raises:
        ValueError: A body needs meshes, and there are none.
    """
    filled = [body for body in bodies if body]
    features, group_of = _features_of_bodies(shape, meshes, filled)
    words = tuple(group_words(shape, leaves) for leaves in filled)
    groups = tuple(group_of[body] for body in filled)
    view = ShapeView(features, groups, True, words, (None,) * len(filled), category_words(shape))
    probabilities, rest = ranker.probabilities(view)
    ranked = {body: (own, float(still)) for body, own, still in zip(filled, probabilities, rest, strict=True)}
    stillest = filled[int(np.argmax(rest))]
    base = bodies[0] or stillest
    resting = {"any": set(filled), "first": {base}, "one": {stillest}}[may_rest]
    estimates: list[tuple[JointEstimate, ...]] = []
    for index, body in enumerate(bodies):
        if not body:
            estimates.append((JointEstimate(None, MotionType.FIXED, 1.0, source="ranking"),))
            continue
        own, still = ranked[body]
        box = symmetric_box(shape, body, meshes)
        own = apply_gnn_prior(own, motion_type_probabilities(shape, body, edges), features, group_of[body], box, shape.up)
        if still >= MIN_REST_PROBABILITY and body not in resting:
            own, still = _with_rest(own, MIN_REST_PROBABILITY / 2)
        if still < MIN_REST_PROBABILITY and may_rest == "first" and body == base:
            own, still = _with_rest(own, MIN_REST_PROBABILITY)
        kind = None if kinds is None else kinds[index]
        if kind is not None:
            own = np.where(features.kinds[features.rows(group_of[body])] == kind.code, own, 0.0)
            own, still = _with_rest(own, 0.0) if own.any() else (own, 1.0)
        estimates.append(rank_joints(features, group_of[body], own, still, box, shape.up))
    return estimates


def _with_rest(probabilities: F64, rest: float) -> tuple[F64, float]:
    """Probabilities of candidates scaled to go with a given probability of rest."""
    return probabilities / probabilities.sum() * (1.0 - rest), rest


def _features_of_bodies(
    shape: PreparedShape, meshes: _core.Meshes | None, bodies: Sequence[tuple[int, ...]]
) -> tuple[CandidateFeatures, dict[tuple[int, ...], int]]:
    """Candidate features of bodies, and the group of each body; features that the shape was prepared with are reused."""
    known = CandidateFeatures.of(shape.candidate_features) if shape.candidate_features else None
    groups = () if known is None else leaf_groups(shape.leaves_below, shape.body_leaves)
    group_of = {leaves: group for group, leaves in enumerate(groups)}
    others = [body for body in dict.fromkeys(bodies) if body not in group_of]
    # The features may have more groups than `groups`: those of bodies of an annotation that was removed from the shape.
    group_of |= {leaves: group for group, leaves in enumerate(others, start=0 if known is None else len(known))}
    if known is not None and not others:
        return known, group_of
    if meshes is None:
        raise ValueError("meshes: needed for bodies that the shape was not prepared with")
    sizes = part_sizes(shape.leaves_below, shape.minimum_boxes)
    computed = compute_candidate_features(ShapeGeometry.of_prepared(shape, meshes), others, sizes)
    found = CandidateFeatures.of(computed.arrays())  # rounded as stored features are
    return found if known is None else known.joined(found), group_of
