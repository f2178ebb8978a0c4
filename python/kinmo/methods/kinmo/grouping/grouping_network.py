"""Grouping network: the probability that two leaves belong to one rigid body, for every pair of the contact graph.

Leaves and pairs have states that a few rounds of message passing update. This is the paper's motion GNN (section 3.2) with
`FIXED` as the only type, on all touching parts instead of siblings.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from kinmo.config import GroupingConfig
from kinmo.learning.network_layers import scatter_max, scatter_mean
from kinmo.methods.kinmo.grouping.grouping_batches import GroupingBatch
from kinmo.methods.kinmo.ranking.name_words import WORD_BUCKETS

KIND = "part_grouping"
"""Kind of the network in files of weights (`kinmo.learning.weights`)."""
NOISE = 0.1
"""Standard deviation of the noise on standardised features in training."""
MAX_FEATURE = 5.0
"""Largest magnitude of a standardised feature."""
MOVES_SHARE = 0.2
"""Weight of the loss of moving leaves, an auxiliary task."""


class GroupingNetwork(nn.Module):
    """Network on the contact graph of a shape's leaves."""

    leaf_mean: Tensor
    leaf_scale: Tensor
    pair_mean: Tensor
    pair_scale: Tensor

    def __init__(self, leaf_features: int, pair_features: int, config: GroupingConfig) -> None:
        super().__init__()
        for name, count in (("leaf", leaf_features), ("pair", pair_features)):
            self.register_buffer(f"{name}_mean", torch.zeros(count))
            self.register_buffer(f"{name}_scale", torch.ones(count))
        width, rounds, dropout = config.width, range(config.rounds), config.dropout
        self.words = nn.Embedding(WORD_BUCKETS, config.word_features)
        nn.init.normal_(self.words.weight, std=0.3)
        self.leaf = _layers(leaf_features + config.word_features, 2 * width, width, dropout)
        self.pair = _layers(pair_features, 2 * width, width, dropout)
        self.pair_rounds = nn.ModuleList(_layers(3 * width, 2 * width, width, dropout) for _ in rounds)
        self.leaf_rounds = nn.ModuleList(_layers(4 * width, 2 * width, width, dropout) for _ in rounds)
        self.pair_norms = nn.ModuleList(nn.LayerNorm(width) for _ in rounds)
        self.leaf_norms = nn.ModuleList(nn.LayerNorm(width) for _ in rounds)
        self.same_body = _layers(3 * width, width, 1, dropout)
        self.moves = _layers(width, width, 1, dropout)

    def standardize(self, leaves: Tensor, pairs: Tensor) -> None:
        """Set mean and scale of the features from raw features [L, G] and [E, F] of training shapes."""
        for name, values in (("leaf", leaves), ("pair", pairs)):
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(values.std(dim=0).clamp_min(1e-3))

    def silence_unknown_words(self, known: Tensor) -> None:
        """Set the embeddings of all buckets to zero, except those of the `known` words."""
        unknown = torch.ones(WORD_BUCKETS, dtype=torch.bool).index_fill(0, known, False)
        with torch.no_grad():
            self.words.weight[unknown] = 0.0

    def forward(self, batch: GroupingBatch) -> tuple[Tensor, Tensor]:
        """Logits [E] of pairs that are one body, the same in both directions, and logits [L] of leaves that move."""
        leaves = ((batch.leaves - self.leaf_mean) / self.leaf_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        pairs = ((batch.contact - self.pair_mean) / self.pair_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        if self.training:
            leaves, pairs = (values + NOISE * torch.randn_like(values) for values in (leaves, pairs))
        named, _ = scatter_mean(self.words(batch.words), batch.word_leaf, len(leaves))
        leaf, pair = self.leaf(torch.cat([leaves, named], dim=1)), self.pair(pairs)
        first, second = batch.pairs.unbind(1)
        steps = zip(self.pair_rounds, self.leaf_rounds, self.pair_norms, self.leaf_norms, strict=True)
        for update_pair, update_leaf, pair_norm, leaf_norm in steps:
            pair = pair_norm(pair + update_pair(torch.cat([leaf[first], leaf[second], pair], dim=1)))
            mean, _ = scatter_mean(pair, first, len(leaf))
            whole, _ = scatter_mean(leaf, batch.graph_of, batch.graphs)
            message = torch.cat([leaf, mean, scatter_max(pair, first, len(leaf)), whole[batch.graph_of]], dim=1)
            leaf = leaf_norm(leaf + update_leaf(message))
        ends = leaf[first] + leaf[second], (leaf[first] - leaf[second]).abs()
        logits = self.same_body(torch.cat([*ends, pair], dim=1))[:, 0].float()
        return 0.5 * (logits + logits[batch.reverse]), self.moves(leaf)[:, 0].float()


def grouping_networks(config: GroupingConfig, leaf_features: int, pair_features: int) -> nn.ModuleList:
    """`config.members` networks of the same sizes."""
    return nn.ModuleList(GroupingNetwork(leaf_features, pair_features, config) for _ in range(config.members))


def mean_logits(networks: nn.ModuleList, batch: GroupingBatch) -> tuple[Tensor, Tensor]:
    """The networks' mean logits of pairs that are one body [E], and of leaves that move [L]."""
    same_body, moves = zip(*(network(batch) for network in networks), strict=True)
    return torch.stack(same_body).mean(dim=0), torch.stack(moves).mean(dim=0)


def grouping_loss(same_body: Tensor, moves: Tensor, batch: GroupingBatch) -> Tensor:
    """Binary cross-entropy of pairs, a mean over graphs, and that of moving leaves with a small weight."""
    pairs = nn.functional.binary_cross_entropy_with_logits(same_body, batch.same_body, reduction="none")
    leaves = nn.functional.binary_cross_entropy_with_logits(moves, batch.moves)
    return (pairs * batch.weights).sum() + MOVES_SHARE * leaves


def _layers(inputs: int, hidden: int, outputs: int, dropout: float) -> nn.Sequential:
    return nn.Sequential(nn.Linear(inputs, hidden), nn.GELU(), nn.Dropout(dropout), nn.Linear(hidden, outputs))
