"""Two views of a shape for the ranking networks: its rigid bodies, and the nodes of its hierarchy, with soft targets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.edge_labels import carriers_of
from kinmo.core.joint import Joint
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape, leaf_groups
from kinmo.methods.kinmo.ranking.name_words import category_words, group_words

F64 = NDArray[np.float64]

ANGLE_SCALE = np.radians(2.0)
"""Angle to the true axis, in radians, that lowers a candidate's target by a factor e."""
LINE_SCALE = 0.015
"""Distance from the true axis, in diagonals, that lowers a candidate's target by a factor e."""
MAX_EXTRA_COST = 4.0
"""Candidates whose cost exceeds the least cost by more than this have a target of 0."""


@dataclass(frozen=True, eq=False)
class ShapeView:
    """Groups of one shape that the networks rank together.

    Attributes:
        features: Candidate joints of the shape.
        groups: Indices of the view's groups in `features`.
        is_bodies: True if the groups are bodies, False if they are nodes.
        words: Hashed words of each group's names.
        targets: Target probabilities [C] of each group's candidates; None for groups at rest, and without an annotation.
        category: Hashed words of the shape's category, which belong to every group.
    """

    features: CandidateFeatures
    groups: tuple[int, ...]
    is_bodies: bool
    words: tuple[tuple[int, ...], ...]
    targets: tuple[F64 | None, ...]
    category: tuple[int, ...] = ()


def body_view(shape: PreparedShape, features: CandidateFeatures) -> ShapeView:
    """View of the bodies of an annotated shape, in their order (setting *parts given*)."""
    mobility, _ = shape.annotation
    joints = [body.joint for body in mobility.bodies]
    return _view(shape, features, shape.body_leaves, joints, is_bodies=True)


def node_view(shape: PreparedShape, features: CandidateFeatures) -> ShapeView:
    """View of the nodes below the root, in preorder (setting *hierarchy given*).

    A node moves if its carrier has a joint and its parent node does not move with that carrier. All other nodes rest.
    """
    joints: list[Joint | None] = [None] * (len(shape.parents) - 1)
    if shape.mobility is not None:
        leaf_sets = [tuple(shape.leaves[p] for p in below) for below in shape.leaves_below]
        carried = carriers_of(leaf_sets, shape.mobility)
        for node in range(1, len(shape.parents)):
            carrier = carried[node]
            if carrier is not None and carried[shape.parents[node]] != carrier:
                joints[node - 1] = shape.mobility.bodies[carrier].joint
    return _view(shape, features, shape.leaves_below[1:], joints, is_bodies=False)


def training_views(shapes: Sequence[PreparedShape]) -> list[ShapeView]:
    """Both views of every annotated shape that has candidate features."""
    views = []
    for shape in shapes:
        if shape.candidate_features and shape.mobility is not None:
            features = CandidateFeatures.of(shape.candidate_features)
            views.append(body_view(shape, features))
            if len(shape.parents) > 1:
                views.append(node_view(shape, features))
    return views


def _view(
    shape: PreparedShape,
    features: CandidateFeatures,
    leaves: Sequence[tuple[int, ...]],
    joints: Sequence[Joint | None],
    *,
    is_bodies: bool,
) -> ShapeView:
    group_of = {each: group for group, each in enumerate(leaf_groups(shape.leaves_below, shape.body_leaves))}
    groups = tuple(group_of[each] for each in leaves)
    targets = tuple(soft_target(features, group, joint) for group, joint in zip(groups, joints, strict=True))
    words = tuple(group_words(shape, each) for each in leaves)
    return ShapeView(features, groups, is_bodies, words, targets, category_words(shape))


def soft_target(features: CandidateFeatures, group: int, joint: Joint | None) -> F64 | None:
    """Target probabilities [C] of a group's candidates: highest for the least cost, shared with candidates about as good."""
    if joint is None:
        return None
    costs = candidate_costs(features, group, joint)
    relative = costs - costs.min()
    target = np.where(relative < MAX_EXTRA_COST, np.exp(-np.minimum(relative, MAX_EXTRA_COST)), 0.0)
    return np.asarray(target / target.sum())


def candidate_costs(features: CandidateFeatures, group: int, joint: Joint) -> F64:
    """Costs [C] of a group's candidates for its true joint: angle and distance errors in units of their scales.

    The distance is measured where the true axis passes nearest to the group's centre. Other kinds have an infinite cost.
    """
    rows = features.rows(group)
    directions, pivots = features.directions[rows], features.pivots[rows]
    cost = np.arccos(np.clip(np.abs(directions @ joint.direction), 0.0, 1.0)) / ANGLE_SCALE
    if joint.has_pivot:
        near_center = joint.pivot + ((features.centers[group] - joint.pivot) @ joint.direction) * joint.direction
        offset = near_center - pivots
        offset -= np.sum(offset * directions, axis=1, keepdims=True) * directions
        cost = cost + np.linalg.norm(offset, axis=1) / LINE_SCALE
    return np.where(features.kinds[rows] == joint.kind.code, cost, np.inf)
