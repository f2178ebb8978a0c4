"""Mobility tree of a shape, from the motion GNN's edge predictions (paper, section 3.3).

The hierarchy is pruned to the parts that take part in a motion. Parts that are fixed to each other and move relative to the
same reference are merged, with the motion parameters of the larger part. If references form a cycle, the least probable motion
edge is left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinmo.core.mobility import Body, has_cycle, path_to_root
from kinmo.core.motion_types import MotionType
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_estimate import GnnEstimate, mean_estimate


@dataclass(frozen=True, eq=False)
class MobilityTree:
    """Bodies without joints, and the motion GNN's estimate for each.

    Attributes:
        bodies: Rigid bodies; `Body.leaves` are indices of parts.
        estimates: Motion parameters of each body; None for bodies at rest.
    """

    bodies: tuple[Body, ...]
    estimates: tuple[GnnEstimate | None, ...]


def tree_with_given_bodies(shape: PreparedShape, predictions: EdgePredictions) -> MobilityTree:
    """Mobility tree in the setting *parts given*: the annotation's bodies, with predicted motions and references.

    A part belongs to the body that holds most of its surface. The edges between the parts of two bodies predict how one body
    moves relative to the other. Different bodies are not fixed to each other, and only the root of a tree rests. Every other
    body therefore gets its most probable motion type. References are chosen in the order of their motion probabilities, without
    cycles. A body without an edge to another body rests. Joints and parents of the annotation are not used.
    """
    mobility, _ = shape.annotation
    owner = _bodies_of_parts(shape)
    moves = predictions.type_probabilities[:, : predictions.type_set.FIXED].sum(axis=1)
    pairs: dict[tuple[int, int], list[int]] = {}
    for edge, (part, other) in enumerate(shape.edges.tolist()):
        if owner[part] != owner[other] and moves[edge] > 0:  # 0 for edges that the network does not see
            pairs.setdefault((owner[part], owner[other]), []).append(edge)
    ordered = sorted(pairs, key=lambda pair: (-float(np.mean(moves[pairs[pair]])), pair))
    parents: dict[int, int] = {}
    estimates: dict[int, GnnEstimate] = {}
    for body, reference in ordered:
        if body not in parents and body not in path_to_root(parents, reference):
            parents[body] = reference
            estimates[body] = _without_fixed(mean_estimate(predictions, np.array(pairs[body, reference])))
    tree = tuple(replace(body, parent=parents.get(index), joint=None) for index, body in enumerate(mobility.bodies))
    return MobilityTree(tree, tuple(estimates.get(index) for index in range(len(tree))))


def with_true_types(tree: MobilityTree, types: Mapping[int, MotionType]) -> MobilityTree:
    """The tree with true motion types (by body) for the bodies whose type is predicted wrongly, no estimates for the others."""
    estimates: list[GnnEstimate | None] = [None] * len(tree.bodies)
    for body, estimate in enumerate(tree.estimates):
        if estimate is None or body not in types:
            continue
        true = types[body] if estimate.type_set is MotionType else types[body].coarse
        if estimate.type is not true:
            probabilities = np.zeros(len(estimate.type_set))
            probabilities[true] = 1.0
            estimates[body] = replace(estimate, probabilities=probabilities)
    return replace(tree, estimates=tuple(estimates))


def _bodies_of_parts(shape: PreparedShape) -> list[int]:
    """The body of the annotation that holds most of the surface of each part."""

    def shared_area(part: tuple[int, ...], body: tuple[int, ...]) -> float:
        return float(shape.leaf_areas[sorted(set(part) & set(body))].sum())

    return [int(np.argmax([shared_area(part, body) for body in shape.body_leaves])) for part in shape.leaves_below]


def _without_fixed(estimate: GnnEstimate) -> GnnEstimate:
    """The estimate for a body that is known to move."""
    fixed = int(estimate.type_set.FIXED)
    moving = np.where(np.arange(len(estimate.probabilities)) < fixed, estimate.probabilities, 0.0)
    return replace(estimate, probabilities=moving / moving.sum())


def tree_with_predicted_bodies(shape: PreparedShape, predictions: EdgePredictions) -> MobilityTree:
    """Mobility tree in the setting *hierarchy given*: parts are merged into bodies as the edges predict (paper, section 3.3).

    The annotation of the shape is not used. Body 0 holds all parts at rest, unless it has no leaves.
    """
    motion = _PartMotions(shape, predictions)
    group_of = _merge_parts(shape, motion)
    groups: dict[int, list[int]] = {}
    for part in motion.references:
        groups.setdefault(group_of[part], []).append(part)
    owners = {part: group for group, parts in groups.items() for part in parts}
    owners |= _fixed_to_moving(motion, group_of)
    number = {group: index + 1 for index, group in enumerate(sorted(groups, key=lambda g: min(groups[g])))}
    body_of = [0] * len(shape.parents)
    for part, parent in enumerate(shape.parents):  # preorder: the parent's body is known
        body_of[part] = number[owners[part]] if part in owners else body_of[parent] if parent >= 0 else 0

    def area(part: int) -> float:
        return float(shape.leaf_areas[list(shape.leaves_below[part])].sum())

    def leaves_of(body: int) -> tuple[int, ...]:
        return tuple(leaf for leaf in shape.leaves if body_of[leaf] == body)

    bodies = [Body(0, "base", leaves_of(0))]
    estimates: list[GnnEstimate | None] = [None]
    for group, index in number.items():
        largest = max(groups[group], key=lambda part: (area(part), -part))
        parent = body_of[motion.references[largest]]
        bodies.append(Body(index, shape.part_names[largest], leaves_of(index), parent))
        estimates.append(mean_estimate(predictions, np.array([motion.edge_of[largest]])))
    return _without_empty_bodies(MobilityTree(tuple(bodies), tuple(estimates)))


class _PartMotions:
    """Predicted motion of every part that moves.

    Attributes:
        references: The reference part of each moving part.
        edge_of: The edge from each moving part to its reference.
        fixed: Mean margin between the probability of FIXED and that of the next most probable type, by pair of parts.
    """

    def __init__(self, shape: PreparedShape, predictions: EdgePredictions) -> None:
        fixed = predictions.type_set.FIXED.value
        probabilities = predictions.type_probabilities
        motion_edges = np.flatnonzero(predictions.types < fixed)
        moves = probabilities[:, :fixed].sum(axis=1)
        self.references: dict[int, int] = {}
        self.edge_of: dict[int, int] = {}
        # Most probable edges first; an edge that closes a cycle is left out.
        for edge in motion_edges[np.argsort(-moves[motion_edges], kind="stable")]:
            part, reference = shape.edges[edge].tolist()
            if part not in self.references and part not in path_to_root(self.references, reference):
                self.references[part], self.edge_of[part] = reference, int(edge)
        margins: dict[tuple[int, int], list[float]] = {}
        next_best = np.delete(probabilities, fixed, axis=1).max(axis=1)
        for (part, other), margin in zip(shape.edges.tolist(), probabilities[:, fixed] - next_best, strict=True):
            margins.setdefault((min(part, other), max(part, other)), []).append(float(margin))
        self.fixed: dict[tuple[int, int], float] = {pair: float(np.mean(values)) for pair, values in margins.items()}


def _merge_parts(shape: PreparedShape, motion: _PartMotions) -> list[int]:
    """Group of every part; parts of one group form one body, or rest and are fixed to each other."""
    group_of = list(range(len(shape.parents)))
    pairs = sorted(pair for pair, margin in motion.fixed.items() if margin > 0)

    def can_merge(part: int, other: int) -> bool:
        """True if both parts rest, or both move relative to the same group."""
        if group_of[part] == group_of[other] or (part in motion.references) != (other in motion.references):
            return False
        return part not in motion.references or group_of[motion.references[part]] == group_of[motion.references[other]]

    changed = True
    while changed:  # a merger may give other parts the same reference
        changed = False
        for part, other in pairs:
            if can_merge(part, other):
                old, new = max(group_of[part], group_of[other]), min(group_of[part], group_of[other])
                trial = [new if value == old else value for value in group_of]
                if not has_cycle(_group_parents(trial, motion)):
                    group_of, changed = trial, True
    return group_of


def _group_parents(group_of: list[int], motion: _PartMotions) -> list[int | None]:
    parents: list[int | None] = [None] * len(group_of)
    for part, reference in motion.references.items():
        parents[group_of[part]] = group_of[reference]
    return parents


def _fixed_to_moving(motion: _PartMotions, group_of: list[int]) -> dict[int, int]:
    """Groups of the parts without a motion that are fixed to a moving sibling with more margin than to any at rest."""
    best: dict[int, tuple[float, int]] = {}
    references = set(motion.references.values())  # they rest
    for pair, margin in motion.fixed.items():
        for part, other in (pair, pair[::-1]):
            if part not in motion.references and part not in references and margin > best.get(part, (0.0, -1))[0]:
                best[part] = (margin, other)
    return {part: group_of[other] for part, (_, other) in best.items() if other in motion.references}


def _without_empty_bodies(tree: MobilityTree) -> MobilityTree:
    """The tree without bodies that have no leaves; their children are attached to their parents."""
    kept = [index for index, body in enumerate(tree.bodies) if body.leaves]
    new_index = {old: new for new, old in enumerate(kept)}

    def parent_of(body: Body) -> int | None:
        parent = body.parent
        while parent is not None and parent not in new_index:
            parent = tree.bodies[parent].parent
        return None if parent is None else new_index[parent]

    bodies = tuple(replace(tree.bodies[index], parent=parent_of(tree.bodies[index])) for index in kept)
    return MobilityTree(bodies, tuple(tree.estimates[index] for index in kept))
