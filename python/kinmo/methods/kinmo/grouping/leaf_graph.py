"""The contact graph of a shape's leaves as the grouping networks read it: features, names, hierarchy and true labels."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.mobility import Mobility
from kinmo.core.name_words import words_of
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.contact_graph import ContactGraph
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.ranking.name_words import has_names, hash_words

F32 = NDArray[np.float32]

NAME_FEATURES = 4
"""Number of features of the names of a pair."""
HIERARCHY_FEATURES = 4
"""Number of features of the places of a pair in the hierarchy."""
DEPTH_SCALE = 3.0
"""Depth in the hierarchy that counts as 1."""


@dataclass(frozen=True, eq=False)
class LeafGraph:
    """The L leaves of a shape, and E directed pairs of them: both directions of every pair.

    Attributes:
        leaves ([L, G] float32): Features of the leaves.
        words: Hashed words of each leaf's name.
        pairs ([E, 2] int64): Positions of the leaves; the second half has the pairs of the first half, reversed.
        contact ([E, F] float32): Features of the pairs (`kinmo.features.contact_graph`).
        names ([E, 4] float32): Whether both leaves are named, and how alike the names are.
        hierarchy ([E, 4] float32): Whether there is a hierarchy, and how near the leaves are in it; 0 for a flat list.
        same_body ([E] bool): True if both leaves belong to one rigid body; False without an annotation.
        moves ([L] bool): True for a leaf of a body that moves; False without an annotation.
        counts ([E] bool): True for pairs without junk.
        has_names: True if names tell leaves apart (`name_words.has_names`).
    """

    leaves: F32
    words: tuple[tuple[int, ...], ...]
    pairs: NDArray[np.int64]
    contact: F32
    names: F32
    hierarchy: F32
    same_body: NDArray[np.bool_]
    moves: NDArray[np.bool_]
    counts: NDArray[np.bool_]
    has_names: bool

    @property
    def has_hierarchy(self) -> bool:
        """True if there are inner nodes below the root."""
        return bool(self.hierarchy.any())


def leaf_graph(shape: PreparedShape) -> LeafGraph | None:
    """The graph of a prepared shape; None if it has fewer than two leaves."""
    if len(shape.leaves) < 2:
        return None
    features, graph = CandidateFeatures.of(shape.candidate_features), ContactGraph.of(shape.contact_graph)
    leaves = features.group_features[[features.group_of[(position,)] for position in range(len(shape.leaves))]]
    names = [shape.part_names[leaf] for leaf in shape.leaves]
    owner = np.full(len(shape.leaves), -1)
    junk = np.zeros(len(shape.leaves), bool)
    if shape.mobility is not None:
        carrier = rigid_carriers(shape.mobility)
        for body, positions in enumerate(shape.body_leaves):
            owner[list(positions)] = carrier[body]
        junk = np.isin(shape.leaves, list(shape.mobility.junk))
    first, second = graph.pairs.T
    return LeafGraph(
        leaves,
        tuple(tuple(hash_words("leaf", name)) for name in names),
        graph.pairs,
        graph.features,
        _name_features(names, graph.pairs),
        _hierarchy_features(shape, graph.pairs),
        owner[first] == owner[second],
        owner >= 0,
        ~(junk[first] | junk[second]),
        has_names(shape),
    )


def rigid_carriers(mobility: Mobility) -> list[int]:
    """The moving body that every body is fixed to, itself if it moves, or -1 if it rests."""

    def carrier(index: int) -> int:
        body = mobility.bodies[index]
        if body.joint is not None:
            return index
        return -1 if body.parent is None else carrier(body.parent)

    return [carrier(index) for index in range(len(mobility.bodies))]


def _name_features(names: list[str], pairs: NDArray[np.int64]) -> F32:
    """Features [E, 4] of two names: both named, same words, share of common words, equal with digits and all."""
    words = [tuple(words_of(name)) for name in names]
    features = np.zeros((len(pairs), NAME_FEATURES), np.float32)
    for row, (first, second) in enumerate(pairs.tolist()):
        own, other = set(words[first]), set(words[second])
        if own and other:
            same = words[first] == words[second]
            features[row] = 1.0, same, len(own & other) / len(own | other), names[first] == names[second]
    return features


def _hierarchy_features(shape: PreparedShape, pairs: NDArray[np.int64]) -> F32:
    """Features [E, 4] of two leaves: 1, siblings, share of the leaves below their lowest common node, its depth."""
    features = np.zeros((len(pairs), HIERARCHY_FEATURES), np.float32)
    if all(parent <= 0 for parent in shape.parents):
        return features
    lines = [list(_upwards(shape.parents, leaf)) for leaf in shape.leaves]
    for row, (first, second) in enumerate(pairs.tolist()):
        other = set(lines[second])
        depth_below = next(place for place, node in enumerate(lines[first]) if node in other)
        common = lines[first][depth_below]
        share = len(shape.leaves_below[common]) / len(shape.leaves)
        depth = (len(lines[first]) - 1 - depth_below) / DEPTH_SCALE
        features[row] = 1.0, lines[first][1] == lines[second][1], share, depth
    return features


def _upwards(parents: tuple[int, ...], node: int) -> Iterator[int]:
    """A node and all nodes above it."""
    while node >= 0:
        yield node
        node = parents[node]
