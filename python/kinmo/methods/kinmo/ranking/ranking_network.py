"""Ranking network: probabilities of the candidate joints of each part, and of the part being at rest.

One softmax per group over {rest, candidate 1, ..., candidate C} chooses kind and axis together. Candidates are encoded one by
one with their group and pooled. The groups of a shape attend to each other, so that a knob sees its door and a drawer the next
drawer. Names enter as hashed words; words that training never saw have no effect, unless they share a bucket with a known one.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn

from kinmo.config import RankingConfig
from kinmo.methods.kinmo.ranking.name_words import WORD_BUCKETS
from kinmo.methods.kinmo.ranking.ranking_batches import RankingBatch

KIND = "joint_ranking"
"""Kind of the networks in files of weights (`kinmo.learning.weights`)."""
CANDIDATE_NOISE, GROUP_NOISE = 0.05, 0.1
"""Standard deviations of the noise on standardised features in training."""
MAX_FEATURE = 5.0
"""Largest magnitude of a standardised feature."""


def group_log_softmax(scores: Tensor, rest: Tensor, group_of: Tensor) -> tuple[Tensor, Tensor]:
    """Log-softmax of each group over its candidates and rest, from the scores of both and the group of each candidate.

    It gives log-probabilities of the candidates [C] and of rest [U].
    """
    peak = rest.scatter_reduce(0, group_of, scores, "amax").detach()
    total = (rest - peak).exp().index_add(0, group_of, (scores - peak[group_of]).exp())
    normalizer = peak + total.log()
    return scores - normalizer[group_of], rest - normalizer


class RankingNetwork(nn.Module):
    """Network that scores candidate joints.

    The names of its attributes are the names of the tensors in files of weights: `unit` is a group, `hypothesis` a candidate.
    """

    hypothesis_mean: Tensor
    hypothesis_scale: Tensor
    unit_mean: Tensor
    unit_scale: Tensor

    def __init__(
        self, candidate_features: int, group_features: int, width: int = 128, words: int = 32, dropout: float = 0.1
    ) -> None:
        super().__init__()
        for name, count in (("hypothesis", candidate_features), ("unit", group_features)):
            self.register_buffer(f"{name}_mean", torch.zeros(count))
            self.register_buffer(f"{name}_scale", torch.ones(count))
        self.words = nn.Embedding(WORD_BUCKETS, words)
        self.unit = nn.Sequential(
            nn.Linear(group_features + words, width), nn.GELU(), nn.Dropout(dropout), nn.Linear(width, width)
        )
        self.hypothesis = nn.Linear(candidate_features, width)
        self.joint = nn.Sequential(nn.LayerNorm(width), nn.GELU(), nn.Linear(width, width), nn.GELU(), nn.Linear(width, width))
        self.pooled = nn.Linear(3 * width, width)
        self.context = nn.TransformerEncoderLayer(
            width, 4, 2 * width, dropout, activation="gelu", batch_first=True, norm_first=True
        )
        self.score = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, 1))
        self.rest = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, 1))

    def standardize(self, candidates: Tensor, groups: Tensor) -> None:
        """Set mean and scale of the features from raw features [C, F] and [U, G] of training shapes."""
        for name, values in (("hypothesis", candidates), ("unit", groups)):
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(values.std(dim=0).clamp_min(1e-3))

    def silence_unknown_words(self, known: Tensor) -> None:
        """Set the embeddings of all buckets to zero, except those of the `known` words."""
        unknown = torch.ones(WORD_BUCKETS, dtype=torch.bool).index_fill(0, known, False)
        with torch.no_grad():
            self.words.weight[unknown] = 0.0

    def forward(self, batch: RankingBatch) -> tuple[Tensor, Tensor]:
        """Log-probabilities of the candidates [C] and of rest [U]."""
        candidates = ((batch.candidates - self.hypothesis_mean) / self.hypothesis_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        groups = ((batch.groups - self.unit_mean) / self.unit_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        if self.training:
            candidates = candidates + CANDIDATE_NOISE * torch.randn_like(candidates)
            groups = groups + GROUP_NOISE * torch.randn_like(groups)
        count = groups.new_ones(len(groups), 1).index_add(0, batch.word_group, groups.new_ones(len(batch.words), 1))
        named = groups.new_zeros(len(groups), self.words.embedding_dim)
        named = named.index_add(0, batch.word_group, self.words(batch.words))
        group = self.unit(torch.cat([groups, named / count], dim=1))
        joint = self.hypothesis(candidates) + group[batch.group_of]
        joint = joint + self.joint(joint)

        index = batch.group_of[:, None].expand_as(joint)
        peak = torch.full_like(group, -1e4).scatter_reduce(0, index, joint, "amax")
        size = groups.new_zeros(len(groups), 1).index_add(0, batch.group_of, groups.new_ones(len(joint), 1))
        mean = torch.zeros_like(group).index_add(0, batch.group_of, joint) / size.clamp_min(1.0)
        token = self.pooled(torch.cat([group, peak, mean], dim=1))

        views, slots = int(batch.view_of.max()) + 1, int(batch.slot_of.max()) + 1
        padded = token.new_zeros(views, slots, token.shape[1]).index_put((batch.view_of, batch.slot_of), token)
        empty = torch.ones(views, slots, dtype=torch.bool, device=token.device)
        empty = empty.index_put((batch.view_of, batch.slot_of), torch.zeros_like(batch.view_of, dtype=torch.bool))
        token = self.context(padded, src_key_padding_mask=empty)[batch.view_of, batch.slot_of]

        scores = self.score(torch.cat([joint, token[batch.group_of]], dim=1))[:, 0]
        whole = batch.groups.dtype  # probabilities are as precise as the input, even where layers are less precise
        return group_log_softmax(scores.to(whole), self.rest(token)[:, 0].to(whole), batch.group_of)


def ranking_networks(config: RankingConfig, candidate_features: int, group_features: int) -> nn.ModuleList:
    """`config.members` networks of the same sizes."""
    return nn.ModuleList(
        RankingNetwork(candidate_features, group_features, config.width, config.word_features, config.dropout)
        for _ in range(config.members)
    )


def mean_log_probabilities(networks: nn.ModuleList, batch: RankingBatch) -> tuple[Tensor, Tensor]:
    """Logarithms of the networks' mean probabilities of the candidates [C] and of rest [U]."""
    outputs = [network(batch) for network in networks]
    shift = math.log(len(outputs))
    candidates, rest = (torch.logsumexp(torch.stack(values), dim=0) - shift for values in zip(*outputs, strict=True))
    return candidates, rest


def correct_probability(log_candidates: Tensor, log_rest: Tensor, batch: RankingBatch) -> Tensor:
    """Weighted mean probability of the candidates with a positive target, and of rest, each in proportion to their targets."""
    right = torch.zeros_like(log_rest).index_add(0, batch.group_of, log_candidates.exp() * (batch.targets > 0))
    each = log_rest.exp() * batch.rest_targets + right * (1.0 - batch.rest_targets)
    return (each * batch.weights).sum() / batch.weights.sum().clamp_min(1e-12)


def ranking_loss(log_candidates: Tensor, log_rest: Tensor, batch: RankingBatch) -> Tensor:
    """Weighted mean cross-entropy of the groups against their soft targets."""
    each = -(batch.rest_targets * log_rest).index_add(0, batch.group_of, batch.targets * log_candidates)
    return (each * batch.weights).sum() / batch.weights.sum().clamp_min(1e-12)
