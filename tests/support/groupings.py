"""Groupings of shapes that take the place of those of a trained network."""

from __future__ import annotations

import numpy as np

from kinmo.features.contact_graph import ContactGraph
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.grouping.grouped_shape import GroupedShape
from kinmo.methods.kinmo.grouping.merge_tree import merge_leaves
from kinmo.methods.kinmo.grouping.part_grouper import Grouping


def grouped_without_network(
    shape: PreparedShape, together: tuple[frozenset[int], ...] = (), *, shows_hierarchy: bool = True
) -> GroupedShape:
    """The shape with a logit of 3 for touching leaves of one of the sets `together`, and of -3 for all other pairs."""
    pairs = ContactGraph.of(shape.contact_graph).pairs
    pairs = pairs[: len(pairs) // 2]
    logits = np.array([3.0 if any(set(pair) <= some for some in together) else -3.0 for pair in pairs.tolist()])
    grouping = Grouping(pairs, logits, np.full(len(shape.leaves), 0.5))
    merges = merge_leaves(len(shape.leaves), pairs, logits)
    return GroupedShape(shape, grouping, merges, True, shows_hierarchy and any(parent > 0 for parent in shape.parents))
