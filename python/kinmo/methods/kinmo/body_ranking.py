"""Ranking of the candidate joints of given bodies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import CandidateFeatures, with_groups
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.symmetric_box import symmetric_box
from kinmo.methods.kinmo.grouping.grouped_shape import GroupedShape
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.ranked_joints import MIN_REST_PROBABILITY, rank_joints
from kinmo.methods.kinmo.ranking.shape_views import view_of_bodies

F64 = NDArray[np.float64]
Group = tuple[int, ...]


def rank_bodies(
    grouped: GroupedShape,
    geometry: ShapeGeometry | None,
    bodies: Sequence[Group],
    ranker: JointRanker,
    *,
    may_rest: Literal["any", "one"] = "any",
    kinds: Sequence[JointKind | None] | None = None,
) -> list[tuple[JointEstimate, ...]]:
    """Ranked joints of every body, best first, in the normalised frame and without limits.

    Args:
        grouped: The shape, as the grouping networks join its leaves; its annotation is not used.
        geometry: Geometry of the leaves. Needed for bodies that the shape was not prepared with.
        bodies: Positions of the leaves of each body.
        ranker: Trained ranking networks.
        may_rest: Bodies that may rest. `any`: every body. `one`: only the body that most likely rests. Bodies of one shape are
            attached to each other, so only one needs to rest.
        kinds: Known joint kinds; None for bodies whose kind is predicted.

    Raises:
        ValueError: A body needs the geometry, and there is none.
    """
    shape = grouped.shape
    filled = [body for body in bodies if body]
    features = features_of_groups(shape, geometry, filled)
    probabilities, rest = ranker.probabilities(view_of_bodies(grouped, features, filled))
    ranked = {body: (own, float(still)) for body, own, still in zip(filled, probabilities, rest, strict=True)}
    resting = set(filled) if may_rest == "any" else {filled[int(np.argmax(rest))]}
    meshes = None if geometry is None else geometry.meshes
    estimates: list[tuple[JointEstimate, ...]] = []
    for index, body in enumerate(bodies):
        if not body:
            estimates.append((JointEstimate(None, MotionType.FIXED, 1.0, source="ranking"),))
            continue
        own, still = ranked[body]
        if still >= MIN_REST_PROBABILITY and body not in resting:
            own, still = _with_rest(own, MIN_REST_PROBABILITY / 2)
        kind = None if kinds is None else kinds[index]
        group = features.group_of[body]
        if kind is not None:
            own = np.where(features.kinds[features.rows(group)] == kind.code, own, 0.0)
            own, still = _with_rest(own, 0.0) if own.any() else (own, 1.0)
        box = symmetric_box(shape, body, meshes)
        estimates.append(rank_joints(features, group, own, still, box, shape.up))
    return estimates


def features_of_groups(
    shape: PreparedShape, geometry: ShapeGeometry | None, groups: Sequence[Group], known: CandidateFeatures | None = None
) -> CandidateFeatures:
    """Candidate features of groups of leaves. Those that are `known`, or else those of the prepared shape, are reused.

    Raises:
        ValueError: A group needs the geometry, and there is none.
    """
    if known is None and shape.candidate_features:
        known = CandidateFeatures.of(shape.candidate_features)
    if known is not None and all(group in known.group_of for group in groups):
        return known
    if geometry is None:
        raise ValueError("geometry: needed for bodies that the shape was not prepared with")
    found = with_groups(known, geometry, groups)
    assert found is not None, "there are groups"
    return found


def _with_rest(probabilities: F64, rest: float) -> tuple[F64, float]:
    """Probabilities of candidates scaled to go with a given probability of rest."""
    return probabilities / probabilities.sum() * (1.0 - rest), rest
