"""A shape whose leaves the grouping networks have joined: proposals of bodies, and how well each holds together.

Proposals are the leaves, the nodes of the merge tree, and the nodes of the hierarchy where it is shown. The ranking networks
decide which of them move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.grouping.leaf_graph import leaf_graph
from kinmo.methods.kinmo.grouping.merge_tree import Merge, merge_leaves
from kinmo.methods.kinmo.grouping.part_grouper import Grouping, PartGrouper

Group = tuple[int, ...]

MAX_LOGIT = 12.0
"""Largest magnitude of a logit that counts, also that of a missing one."""
COHESION_FEATURES = 11
"""Number of features of `GroupedShape.cohesion`."""


@dataclass(frozen=True, eq=False)
class GroupedShape:
    """A prepared shape, what the grouping networks say of its leaves, and what the networks were shown.

    Attributes:
        shape: The shape.
        grouping: Logits of the pairs of touching leaves.
        merges: The merge tree.
        shows_names: True if the names of the parts were shown, and tell them apart.
        shows_hierarchy: True if the hierarchy was shown, and there is one.
    """

    shape: PreparedShape
    grouping: Grouping
    merges: Sequence[Merge]
    shows_names: bool
    shows_hierarchy: bool

    @property
    def proposals(self) -> tuple[Group, ...]:
        """Distinct sets of leaves (their positions, ascending) that may be a body; never all leaves of the shape."""
        count = len(self.shape.leaves)
        groups: list[Group] = [(leaf,) for leaf in range(count)]
        groups += [merge.leaves for merge in self.merges]
        if self.shows_hierarchy:
            groups += self.shape.leaves_below[1:]
        return tuple(group for group in dict.fromkeys(groups) if len(group) < count)

    def cohesion(self, groups: Sequence[Group]) -> NDArray[np.float32]:
        """Features [U, 11] that tell how well each group holds together, and how well it is set apart from the others.

        They are the logits of the merges that made the group and that absorb it; mean and least logit inside it; mean and
        largest logit of the pairs that lead out of it, and their number; mean and least probability that its leaves move;
        whether it is a node of the hierarchy, and one of the merge tree.
        """
        made = {merge.leaves: merge.logit for merge in self.merges}
        absorbed = {half: merge.logit for merge in self.merges for half in merge.halves}
        nodes = set(self.shape.leaves_below[1:]) if self.shows_hierarchy else set()
        member = np.zeros((len(groups), len(self.shape.leaves)), bool)
        for row, group in enumerate(groups):
            member[row, list(group)] = True
        first, second = member[:, self.grouping.pairs[:, 0]], member[:, self.grouping.pairs[:, 1]]
        features = np.zeros((len(groups), COHESION_FEATURES), np.float32)
        for row, group in enumerate(groups):
            inside = self.grouping.logits[first[row] & second[row]]
            outside = self.grouping.logits[first[row] ^ second[row]]
            moves, is_leaf = self.grouping.moves[list(group)], len(group) == 1
            features[row] = (
                made.get(group, MAX_LOGIT if is_leaf else 0.0),
                absorbed.get(group, -MAX_LOGIT if is_leaf or group in made else 0.0),
                *((inside.mean(), inside.min()) if len(inside) else (MAX_LOGIT, MAX_LOGIT)),
                *((outside.mean(), outside.max()) if len(outside) else (-MAX_LOGIT, -MAX_LOGIT)),
                np.log1p(len(outside)),
                moves.mean(),
                moves.min(),
                group in nodes,
                is_leaf or group in made,
            )
        return np.clip(features, -MAX_LOGIT, MAX_LOGIT)


def group_shape(
    shape: PreparedShape,
    grouper: PartGrouper,
    *,
    shows_names: bool = True,
    shows_hierarchy: bool = True,
    noise: float = 0.0,
    rng: np.random.Generator | None = None,
) -> GroupedShape:
    """Join the leaves of a shape by trained grouping networks.

    Args:
        shape: The shape; its annotation is not used.
        grouper: The networks.
        shows_names: Show the names of the parts to the networks.
        shows_hierarchy: Show the hierarchy, if there is one.
        noise: Standard deviation of noise on the logits, for training: the networks are too sure of shapes that they have seen.
        rng: Source of the noise.
    """
    graph = leaf_graph(shape)
    if graph is None:
        alone = Grouping(np.zeros((0, 2), np.int64), np.zeros(0), np.zeros(len(shape.leaves)))
        return GroupedShape(shape, alone, (), False, False)
    grouping = grouper.group(graph, hide_names=not shows_names, hide_hierarchy=not shows_hierarchy)
    if rng is not None and noise:
        grouping = replace(grouping, logits=grouping.logits + noise * rng.standard_normal(len(grouping.logits)))
    merges = merge_leaves(len(shape.leaves), grouping.pairs, grouping.logits)
    return GroupedShape(shape, grouping, merges, shows_names and graph.has_names, shows_hierarchy and graph.has_hierarchy)
