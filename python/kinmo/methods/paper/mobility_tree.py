"""From what the network says of edges to rigid bodies and what each moves against (paper, section 3.3).

The hierarchy is pruned to the parts that take part in a motion; parts that are fixed to each other and move against the same
reference become one, with the parameters of the larger; where references would form a cycle, the least sure edge is cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import MotionType
from kinmo.core.mobility import Body, has_cycle, upwards
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_estimate import GnnEstimate, mean_estimate

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MobilityTree:
    """Bodies without joints yet (`leaves` are indices of parts), and of each what the network says; None: it has no edge."""

    bodies: tuple[Body, ...]
    estimates: tuple[GnnEstimate | None, ...]


def given_tree(shape: PreparedShape, predictions: EdgePredictions) -> MobilityTree:
    """*Parts given*: the bodies of the shape's annotation, nothing of its joints or of what hangs on what.

    A part stands for the body that holds most of its surface, and the edges between the parts of two bodies say how the one
    moves against the other. Different bodies are not fixed to each other, and in a tree only one rests; so every other body has
    the most probable motion against its reference, the surest references first and none that closes a cycle. A body without
    an edge to another rests. Raises ValueError for a shape that is not annotated.
    """
    if shape.mobility is None:
        raise ValueError(f"shape {shape.id} is not annotated")
    owner = _owners(shape)
    sure = predictions.type_probabilities[:, : predictions.type_set.FIXED].sum(axis=1)
    pairs: dict[tuple[int, int], list[int]] = {}
    for edge, (part, other) in enumerate(shape.edges.tolist()):
        if owner[part] != owner[other] and sure[edge] > 0:  # 0: the network did not see it
            pairs.setdefault((owner[part], owner[other]), []).append(edge)
    surest = sorted(pairs, key=lambda pair: (-float(np.mean(sure[pairs[pair]])), pair))
    parents: dict[int, int] = {}
    estimates: dict[int, GnnEstimate] = {}
    for body, reference in surest:
        if body not in parents and body not in upwards(parents, reference):
            parents[body] = reference
            estimates[body] = _moving(mean_estimate(predictions, np.array(pairs[body, reference])))
    bodies = enumerate(shape.mobility.bodies)
    tree = tuple(Body(body.id, body.name, body.leaves, parents.get(index)) for index, body in bodies)
    return MobilityTree(tree, tuple(estimates.get(index) for index in range(len(tree))))


def retyped(tree: MobilityTree, types: Mapping[int, MotionType]) -> MobilityTree:
    """The bodies of `tree` that the network gives another type than `types` does, by body, with that type; nothing is said of
    the others.
    """
    estimates: list[GnnEstimate | None] = [None] * len(tree.bodies)
    for body, estimate in enumerate(tree.estimates):
        if estimate is None or body not in types:
            continue
        wanted = types[body] if estimate.type_set is MotionType else types[body].coarse
        if estimate.type is not wanted:
            told = np.zeros(len(estimate.type_set))
            told[wanted] = 1.0
            estimates[body] = replace(estimate, probabilities=told)
    return replace(tree, estimates=tuple(estimates))


def _owners(shape: PreparedShape) -> list[int]:
    """For every part, the body of the annotation that holds most of its surface."""

    def held(part: tuple[int, ...], body: tuple[int, ...]) -> float:
        return float(shape.leaf_areas[sorted(set(part) & set(body))].sum())

    return [int(np.argmax([held(part, body) for body in shape.body_leaves])) for part in shape.leaves_below]


def _moving(estimate: GnnEstimate) -> GnnEstimate:
    """The estimate for a body of which it is known that it moves."""
    fixed = int(estimate.type_set.FIXED)
    odds = np.where(np.arange(len(estimate.probabilities)) < fixed, estimate.probabilities, 0.0)
    return replace(estimate, probabilities=odds / odds.sum())


def predicted_tree(shape: PreparedShape, predictions: EdgePredictions) -> MobilityTree:
    """*Hierarchy given*: which parts form bodies is read off the edges. Body 0 is what everything rests on."""
    motion = _Motion(shape, predictions)
    group_of = _merged(shape, motion)
    groups: dict[int, list[int]] = {}
    for part in motion.references:
        groups.setdefault(group_of[part], []).append(part)
    owners = {part: group for group, parts in groups.items() for part in parts}
    owners |= _companions(shape, motion, group_of)
    number = {group: index + 1 for index, group in enumerate(sorted(groups, key=lambda g: min(groups[g])))}
    body_of = [0] * len(shape.parents)
    for part, parent in enumerate(shape.parents):  # preorder: what is above is known
        body_of[part] = number[owners[part]] if part in owners else body_of[parent] if parent >= 0 else 0
    bodies = [Body(0, "base", _leaves(shape, body_of, 0))]
    estimates: list[GnnEstimate | None] = [None]
    for group in number:
        largest = max(groups[group], key=lambda part: (_area(shape, part), -part))
        edge = motion.edge_of[largest]
        index = number[group]
        bodies.append(
            Body(index, shape.part_names[largest], _leaves(shape, body_of, index), body_of[motion.references[largest]])
        )
        estimates.append(mean_estimate(predictions, np.array([edge])))
    return _without_empty(MobilityTree(tuple(bodies), tuple(estimates)))


class _Motion:
    """For every part that moves, what it moves against (`references`) and by which edge (`edge_of`).

    `fixed` says of pairs by how much FIXED is more probable than any other type, on average over both directions.
    """

    def __init__(self, shape: PreparedShape, predictions: EdgePredictions) -> None:
        fixed = predictions.type_set.FIXED.value
        chosen, probabilities = predictions.types, predictions.type_probabilities
        moves = np.flatnonzero(chosen < fixed)
        sure = probabilities[:, :fixed].sum(axis=1)
        self.references: dict[int, int] = {}
        self.edge_of: dict[int, int] = {}
        for edge in moves[np.argsort(-sure[moves], kind="stable")]:  # the surest first: an edge that closes a cycle is left out
            part, reference = shape.edges[edge].tolist()
            if part not in self.references and part not in upwards(self.references, reference):
                self.references[part], self.edge_of[part] = reference, int(edge)
        both: dict[tuple[int, int], list[float]] = {}
        rival = np.delete(probabilities, fixed, axis=1).max(axis=1)
        for (part, other), odds in zip(shape.edges.tolist(), probabilities[:, fixed] - rival, strict=True):
            both.setdefault((min(part, other), max(part, other)), []).append(float(odds))
        self.fixed: dict[tuple[int, int], float] = {pair: float(np.mean(odds)) for pair, odds in both.items()}


def _merged(shape: PreparedShape, motion: _Motion) -> list[int]:
    """A number for every part; parts with the same one are one body (parts at rest that are fixed to each other, too)."""
    number = list(range(len(shape.parents)))
    pairs = sorted(pair for pair, margin in motion.fixed.items() if margin > 0)

    def fit(part: int, other: int) -> bool:
        """Whether both rest, or both move against the same."""
        if number[part] == number[other] or (part in motion.references) != (other in motion.references):
            return False
        return part not in motion.references or number[motion.references[part]] == number[motion.references[other]]

    changed = True
    while changed:  # a merger may make the references of other parts one
        changed = False
        for part, other in pairs:
            if fit(part, other):
                old, new = max(number[part], number[other]), min(number[part], number[other])
                trial = [new if value == old else value for value in number]
                if not has_cycle(_group_parents(trial, motion)):
                    number, changed = trial, True
    return number


def _group_parents(number: list[int], motion: _Motion) -> list[int | None]:
    parents: list[int | None] = [None] * len(number)
    for part, reference in motion.references.items():
        parents[number[part]] = number[reference]
    return parents


def _companions(shape: PreparedShape, motion: _Motion, group_of: list[int]) -> dict[int, int]:
    """Parts without a motion of their own that are more surely fixed to a moving sibling than to any that rests."""
    best: dict[int, tuple[float, int]] = {}
    anchors = set(motion.references.values())  # what others move against rests
    for pair, margin in motion.fixed.items():
        for part, other in (pair, pair[::-1]):
            if part not in motion.references and part not in anchors and margin > best.get(part, (0.0, -1))[0]:
                best[part] = (margin, other)
    return {part: group_of[other] for part, (_, other) in best.items() if other in motion.references}


def _leaves(shape: PreparedShape, body_of: list[int], body: int) -> tuple[int, ...]:
    return tuple(leaf for leaf in shape.leaves if body_of[leaf] == body)


def _area(shape: PreparedShape, part: int) -> float:
    return float(shape.leaf_areas[list(shape.leaves_below[part])].sum())


def _without_empty(tree: MobilityTree) -> MobilityTree:
    """The tree without bodies that have no leaf left; what was attached to one is attached to what that was attached to."""
    kept = [index for index, body in enumerate(tree.bodies) if body.leaves]
    place = {old: new for new, old in enumerate(kept)}

    def parent_of(body: Body) -> int | None:
        parent = body.parent
        while parent is not None and parent not in place:
            parent = tree.bodies[parent].parent
        return None if parent is None else place[parent]

    bodies = (tree.bodies[index] for index in kept)
    return MobilityTree(
        tuple(Body(b.id, b.name, b.leaves, parent_of(b)) for b in bodies), tuple(tree.estimates[index] for index in kept)
    )
