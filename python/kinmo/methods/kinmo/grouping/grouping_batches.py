"""Batches of leaf graphs for the grouping networks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from kinmo.methods.kinmo.grouping.leaf_graph import LeafGraph

FULL_WEIGHT = 8
"""Number of pairs from which a graph has its full weight in the loss; a graph with fewer counts less."""


@dataclass(frozen=True)
class GroupingBatch:
    """Several graphs as flat tensors: L leaves and E directed pairs of B graphs.

    Attributes:
        leaves ([L, G + 2] float32): Features of the leaves; the last two are whether names are shown, and log L of the graph.
        pairs ([E, 2] int64): The leaves of each pair.
        contact ([E, F] float32): Features of the pairs, with those of names and hierarchy.
        graph_of ([L] int64): Graph of each leaf.
        sizes ([B] int64): Number of leaves of each graph.
        words ([W] int64): Hashed words.
        word_leaf ([W] int64): Leaf of each word.
        reverse ([E] int64): The same pair in the other direction.
        same_body ([E] float32): 1 for pairs of one body, 0 for others.
        weights ([E] float32): Weights of the pairs in the loss.
        moves ([L] float32): 1 for leaves that move, 0 for others.
    """

    leaves: Tensor
    pairs: Tensor
    contact: Tensor
    graph_of: Tensor
    sizes: Tensor
    words: Tensor
    word_leaf: Tensor
    reverse: Tensor
    same_body: Tensor
    weights: Tensor
    moves: Tensor

    def to(self, device: torch.device) -> GroupingBatch:
        """The batch on a device."""
        return GroupingBatch(*(values.to(device) for values in vars(self).values()))

    @property
    def graphs(self) -> int:
        """Number of graphs."""
        return len(self.sizes)


def collate_graphs(
    graphs: Sequence[LeafGraph],
    *,
    rng: np.random.Generator | None = None,
    hide_names: float = 0.0,
    hide_hierarchy: float = 0.0,
    hide_leaf: float = 0.0,
    hide_words: float = 0.0,
) -> GroupingBatch:
    """Join graphs to one flat batch.

    Args:
        graphs: Graphs of shapes.
        rng: Source of the draws. Without it, only what is hidden with probability 1 is hidden.
        hide_names: Probability that all names of a graph are hidden.
        hide_hierarchy: Probability that the hierarchy of a graph is hidden.
        hide_leaf: Probability that the name of one leaf is hidden.
        hide_words: Probability that the words of a graph are hidden, but not how alike they are, as in an unknown language.
    """

    def drawn(probability: float) -> bool:
        return probability >= 1.0 or (rng is not None and bool(rng.random() < probability))

    leaves, pairs, contact, reverse, weights = [], [], [], [], []
    words: list[int] = []
    word_leaf: list[int] = []
    start = start_pair = 0
    for graph in graphs:
        count, half = len(graph.leaves), len(graph.pairs) // 2
        shows_names, shows_hierarchy = graph.has_names and not drawn(hide_names), not drawn(hide_hierarchy)
        shown = np.full(count, shows_names)
        if rng is not None and hide_leaf:
            shown &= rng.random(count) >= hide_leaf
        whole = np.column_stack([np.full(count, shows_names), np.full(count, np.log(count))])
        leaves.append(np.concatenate([graph.leaves, whole.astype(np.float32)], axis=1))
        names = graph.names * shown[graph.pairs].all(axis=1, keepdims=True)
        hierarchy = graph.hierarchy if shows_hierarchy else np.zeros_like(graph.hierarchy)
        contact.append(np.concatenate([graph.contact, names, hierarchy], axis=1, dtype=np.float32))
        for leaf in () if drawn(hide_words) else np.flatnonzero(shown):
            words += graph.words[leaf]
            word_leaf += [start + int(leaf)] * len(graph.words[leaf])
        pairs.append(graph.pairs + start)
        reverse.append(start_pair + np.roll(np.arange(2 * half), half))
        weights.append(graph.counts / max(graph.counts.sum(), 1) * min(1.0, 2 * half / FULL_WEIGHT) / len(graphs))
        start, start_pair = start + count, start_pair + 2 * half
    sizes = [len(graph.leaves) for graph in graphs]
    return GroupingBatch(
        torch.from_numpy(np.concatenate(leaves)),
        torch.from_numpy(np.concatenate(pairs)),
        torch.from_numpy(np.concatenate(contact)),
        torch.from_numpy(np.repeat(np.arange(len(graphs)), sizes)),
        torch.tensor(sizes),
        torch.tensor(words, dtype=torch.long),
        torch.tensor(word_leaf, dtype=torch.long),
        torch.from_numpy(np.concatenate(reverse)),
        torch.from_numpy(np.concatenate([graph.same_body for graph in graphs]).astype(np.float32)),
        torch.from_numpy(np.concatenate(weights).astype(np.float32)),
        torch.from_numpy(np.concatenate([graph.moves for graph in graphs]).astype(np.float32)),
    )
