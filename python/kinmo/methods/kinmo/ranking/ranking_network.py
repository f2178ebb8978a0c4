"""The ranking network: which of a part's hypotheses is its joint, or does it not move at all?

One softmax a unit over {rest, hypothesis 1, ... hypothesis h} decides kind and axis together. Hypotheses are encoded one by one
together with their unit, pooled, and the units of a shape attend to each other, so that a knob sees the door that it sits on
and one drawer the next. Names enter as hashed words; an unknown one says nothing, unless it shares a bucket with a known one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from kinmo.config import RankingConfig

KIND = "joint_ranking"
"""The name of its weights (`learning.weights`)."""
WORD_BUCKETS = 1024


@dataclass(frozen=True)
class RankingBatch:
    """Views of several shapes, flat: S views, U units, H hypotheses.

    `hypotheses` [H, F], `units` [U, G] float32 (raw features); `unit_of` [H], `view_of` [U], `slot_of` [U] (the unit's place in
    its view) int64; `words` [W] hashed words with `word_unit` [W], the unit they belong to.
    """

    hypotheses: Tensor
    units: Tensor
    unit_of: Tensor
    view_of: Tensor
    slot_of: Tensor
    words: Tensor
    word_unit: Tensor
    targets: Tensor
    rest_targets: Tensor
    weights: Tensor

    def to(self, device: torch.device) -> RankingBatch:
        return RankingBatch(*(getattr(self, name).to(device) for name in self.__dataclass_fields__))


def segment_log_softmax(scores: Tensor, rest: Tensor, unit_of: Tensor) -> tuple[Tensor, Tensor]:
    """Log-probabilities of hypotheses [H] and of rest [U] under one softmax a unit."""
    peak = rest.scatter_reduce(0, unit_of, scores, "amax").detach()
    total = (rest - peak).exp().index_add(0, unit_of, (scores - peak[unit_of]).exp())
    normalizer = peak + total.log()
    return scores - normalizer[unit_of], rest - normalizer


class JointRanker(nn.Module):
    """Scores hypotheses. `forward` returns log-probabilities of the hypotheses [H] and of not moving [U]."""

    hypothesis_mean: Tensor
    hypothesis_scale: Tensor
    unit_mean: Tensor
    unit_scale: Tensor

    def __init__(
        self, hypothesis_features: int, unit_features: int, width: int = 128, words: int = 32, dropout: float = 0.1
    ) -> None:
        super().__init__()
        self.register_buffer("hypothesis_mean", torch.zeros(hypothesis_features))
        self.register_buffer("hypothesis_scale", torch.ones(hypothesis_features))
        self.register_buffer("unit_mean", torch.zeros(unit_features))
        self.register_buffer("unit_scale", torch.ones(unit_features))
        self.words = nn.Embedding(WORD_BUCKETS, words)
        self.unit = nn.Sequential(
            nn.Linear(unit_features + words, width), nn.GELU(), nn.Dropout(dropout), nn.Linear(width, width)
        )
        self.hypothesis = nn.Linear(hypothesis_features, width)
        self.joint = nn.Sequential(nn.LayerNorm(width), nn.GELU(), nn.Linear(width, width), nn.GELU(), nn.Linear(width, width))
        self.pooled = nn.Linear(3 * width, width)
        self.context = nn.TransformerEncoderLayer(
            width, 4, 2 * width, dropout, activation="gelu", batch_first=True, norm_first=True
        )
        self.score = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, 1))
        self.rest = nn.Sequential(nn.LayerNorm(width), nn.Linear(width, width), nn.GELU(), nn.Linear(width, 1))

    def standardize(self, hypotheses: Tensor, units: Tensor) -> None:
        """Takes mean and spread of the training set's raw features."""
        for name, values in (("hypothesis", hypotheses), ("unit", units)):
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(values.std(dim=0).clamp_min(1e-3))

    def silence(self, known: Tensor) -> None:
        """Words that are not among the `known` ones say nothing, instead of something at random."""
        unknown = torch.ones(WORD_BUCKETS, dtype=torch.bool).index_fill(0, known, False)
        with torch.no_grad():
            self.words.weight[unknown] = 0.0

    def forward(self, batch: RankingBatch) -> tuple[Tensor, Tensor]:
        hypotheses = ((batch.hypotheses - self.hypothesis_mean) / self.hypothesis_scale).clamp(-5, 5)
        units = ((batch.units - self.unit_mean) / self.unit_scale).clamp(-5, 5)
        if self.training:
            hypotheses = hypotheses + 0.05 * torch.randn_like(hypotheses)
            units = units + 0.1 * torch.randn_like(units)
        count = units.new_ones(len(units), 1).index_add(0, batch.word_unit, units.new_ones(len(batch.words), 1))
        named = units.new_zeros(len(units), self.words.embedding_dim).index_add(0, batch.word_unit, self.words(batch.words))
        unit = self.unit(torch.cat([units, named / count], dim=1))
        joint = self.hypothesis(hypotheses) + unit[batch.unit_of]
        joint = joint + self.joint(joint)

        index = batch.unit_of[:, None].expand_as(joint)
        peak = torch.full_like(unit, -1e4).scatter_reduce(0, index, joint, "amax")
        size = units.new_zeros(len(units), 1).index_add(0, batch.unit_of, units.new_ones(len(joint), 1))
        mean = torch.zeros_like(unit).index_add(0, batch.unit_of, joint) / size.clamp_min(1.0)
        token = self.pooled(torch.cat([unit, peak, mean], dim=1))

        views, slots = int(batch.view_of.max()) + 1, int(batch.slot_of.max()) + 1
        padded = token.new_zeros(views, slots, token.shape[1]).index_put((batch.view_of, batch.slot_of), token)
        empty = torch.ones(views, slots, dtype=torch.bool, device=token.device)
        empty = empty.index_put((batch.view_of, batch.slot_of), torch.zeros_like(batch.view_of, dtype=torch.bool))
        token = self.context(padded, src_key_padding_mask=empty)[batch.view_of, batch.slot_of]

        scores = self.score(torch.cat([joint, token[batch.unit_of]], dim=1))[:, 0]
        whole = batch.units.dtype  # probabilities are as precise as what comes in, even where layers are less so
        return segment_log_softmax(scores.to(whole), self.rest(token)[:, 0].to(whole), batch.unit_of)


def rankers(config: RankingConfig, hypothesis_features: int, unit_features: int) -> nn.ModuleList:
    """`config.members` networks of the same build."""
    return nn.ModuleList(
        JointRanker(hypothesis_features, unit_features, config.width, config.word_features, config.dropout)
        for _ in range(config.members)
    )


def averaged(networks: nn.ModuleList, batch: RankingBatch) -> tuple[Tensor, Tensor]:
    """Logarithms of the members' mean probabilities of hypotheses [H] and of rest [U]."""
    said = [network(batch) for network in networks]
    shift = math.log(len(said))
    hypotheses, rest = (torch.logsumexp(torch.stack(values), dim=0) - shift for values in zip(*said, strict=True))
    return hypotheses, rest


def right_probability(log_hypotheses: Tensor, log_rest: Tensor, batch: RankingBatch) -> Tensor:
    """Probability [U] of all that the target of each unit holds to be right."""
    right = log_hypotheses.exp() * (batch.targets > 0)
    return (log_rest.exp() * batch.rest_targets).index_add(0, batch.unit_of, right)


def ranking_loss(log_hypotheses: Tensor, log_rest: Tensor, batch: RankingBatch) -> Tensor:
    """Cross-entropy against soft targets, weighted by unit."""
    each = -(batch.rest_targets * log_rest).index_add(0, batch.unit_of, batch.targets * log_hypotheses)
    return (batch.weights * each).sum() / batch.weights.sum().clamp_min(1e-6)
