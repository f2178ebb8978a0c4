"""Views of a shape for the ranking networks: groups of leaves that are ranked together, with soft targets.

A view holds the rigid bodies of a shape, where they are given, or proposals of bodies (`GroupedShape.proposals`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.oriented_box import have_similar_size
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.grouping.grouped_shape import GroupedShape
from kinmo.methods.kinmo.grouping.leaf_graph import rigid_carriers
from kinmo.methods.kinmo.ranking.name_words import category_words, group_words

F64 = NDArray[np.float64]
Group = tuple[int, ...]

ANGLE_SCALE = np.radians(2.0)
"""Angle to the true axis, in radians, that lowers a candidate's target by a factor e."""
LINE_SCALE = 0.015
"""Distance from the true axis, in diagonals, that lowers a candidate's target by a factor e."""
MAX_EXTRA_COST = 4.0
"""Candidates whose cost exceeds the least cost by more than this have a target of 0."""
MIN_OVERLAP = 0.5
"""Least overlap (intersection over union of areas) of a proposal with a body that it stands for."""
OVERLAP_POWER = 4
"""Power of the overlap, relative to the best proposal for the body, in the target probability that a proposal moves."""


@dataclass(frozen=True, eq=False)
class ShapeView:
    """Groups of one shape that the networks rank together.

    Attributes:
        features: Candidate joints of the shape.
        groups: Indices of the view's U groups in `features`.
        context ([U, K] float32): Features of the groups in the view: those of `_context`.
        words: Hashed words of each group's names; empty where names are hidden.
        category: Hashed words of the shape's category, which belong to every group.
        targets: Target probabilities [C] of each group's candidates. What is missing to 1 is the target of rest.
        weights ([U] float64): Weights of the groups in the loss.
    """

    features: CandidateFeatures
    groups: tuple[int, ...]
    context: NDArray[np.float32]
    words: tuple[tuple[int, ...], ...]
    category: tuple[int, ...]
    targets: tuple[F64, ...]
    weights: F64

    @property
    def has_joints(self) -> bool:
        """True if a group moves."""
        return any(target.any() for target in self.targets)


def view_of_bodies(grouped: GroupedShape, features: CandidateFeatures, bodies: Sequence[Group]) -> ShapeView:
    """View of given bodies, which each have leaves; without targets."""
    return _view(grouped, features, bodies, is_given=True)


def view_of_proposals(grouped: GroupedShape, features: CandidateFeatures, proposals: Sequence[Group]) -> ShapeView:
    """View of proposals of bodies; without targets."""
    return _view(grouped, features, proposals, is_given=False)


def with_targets_of_bodies(view: ShapeView, mobility: Mobility) -> ShapeView:
    """The view with the joints of its bodies, all those of the annotation in their order, as targets."""
    joints = [body.joint for body in mobility.bodies]
    shares = [float(joint is not None) for joint in joints]
    return _with_targets(view, joints, shares, [True] * len(joints))


def with_targets_of_proposals(view: ShapeView, shape: PreparedShape, proposals: Sequence[Group]) -> ShapeView:
    """The view with targets from the annotation of the shape, in the order of the `proposals`.

    A proposal moves as the body that it overlaps most, with the bodies fixed to it, or with all that moves along. The better
    it is, compared with the best proposal for that body, the higher its target. Proposals of junk alone do not count.
    """
    mobility, _ = shape.annotation
    areas = np.maximum(shape.leaf_areas, 1e-12)
    member = np.zeros((len(proposals), len(areas)))
    for row, proposal in enumerate(proposals):
        member[row, list(proposal)] = 1.0
    junk = np.isin(shape.leaves, list(mobility.junk))
    counts = member @ ~junk > 0
    movable = list(mobility.movable())
    carrier = rigid_carriers(mobility)
    overlaps = np.zeros((len(proposals), len(movable)))
    for column, (index, _) in enumerate(movable):
        fixed = [body for body, carried in enumerate(carrier) if carried == index]
        for bodies in (fixed, mobility.descendants(index)):
            own = np.zeros(len(areas))
            for body in bodies:
                own[list(shape.body_leaves[body])] = 1.0
            common = member @ (own * areas)
            union = member @ areas + own @ areas - common
            overlaps[:, column] = np.maximum(overlaps[:, column], common / union)
    joints: list[Joint | None] = [None] * len(proposals)
    shares = [0.0] * len(proposals)
    if movable:
        best = np.maximum(overlaps.max(axis=0), 1e-12)
        for row, column in enumerate(overlaps.argmax(axis=1)):
            if overlaps[row, column] >= MIN_OVERLAP:
                joints[row] = movable[column][1].joint
                shares[row] = float((overlaps[row, column] / best[column]) ** OVERLAP_POWER)
    return _with_targets(view, joints, shares, counts.tolist())


def _view(grouped: GroupedShape, features: CandidateFeatures, groups: Sequence[Group], *, is_given: bool) -> ShapeView:
    shape = grouped.shape
    rows = tuple(features.group_of[group] for group in groups)
    words: tuple[tuple[int, ...], ...] = ((),) * len(rows)
    if grouped.shows_names:
        words = tuple(group_words(shape, group, sees_hierarchy=grouped.shows_hierarchy) for group in groups)
    targets = tuple(np.zeros(count) for count in features.counts(rows))
    context = _context(grouped, features, groups, rows, is_given)
    return ShapeView(features, rows, context, words, category_words(shape), targets, np.ones(len(rows)))


def _context(
    grouped: GroupedShape, features: CandidateFeatures, groups: Sequence[Group], rows: Sequence[int], is_given: bool
) -> NDArray[np.float32]:
    """Cohesion of the groups, number of groups and of those alike, whether bodies are given, whether there is a hierarchy."""
    sizes = features.half_extents[list(rows)]
    alike = [np.log1p(have_similar_size(size, sizes).sum()) for size in sizes]
    same = [np.log(len(rows)), float(is_given), float(grouped.shows_hierarchy)]
    return np.column_stack([grouped.cohesion(groups), alike, np.tile(same, (len(rows), 1))]).astype(np.float32)


def _with_targets(
    view: ShapeView, joints: Sequence[Joint | None], shares: Sequence[float], counts: Sequence[bool]
) -> ShapeView:
    """The view with each group's joint as a target of total probability `shares`. A view weighs the root of its size."""
    found = []
    for group, joint, share, zeros in zip(view.groups, joints, shares, view.targets, strict=True):
        found.append(zeros if joint is None else share * soft_target(view.features, group, joint))
    weights = np.array(counts, float) / np.sqrt(max(sum(counts), 1))
    return ShapeView(view.features, view.groups, view.context, view.words, view.category, tuple(found), weights)


def soft_target(features: CandidateFeatures, group: int, joint: Joint) -> F64:
    """Target probabilities [C] of a group's candidates: highest for the least cost, shared with candidates about as good."""
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
