"""Limits network: distribution of the travel of a joint in each of its senses, and the probability that it has limits.

Travel is told in scales of the joint (`kinmo.features.travel_features`). The network sees one sense at a time, beside the
other, so that turning the direction of a joint around exchanges its limits and changes nothing else.
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from kinmo.config import LimitsConfig
from kinmo.methods.kinmo.limits.travel_examples import NO_WORD, UNLIMITED
from kinmo.methods.kinmo.ranking.name_words import WORD_BUCKETS

F64 = NDArray[np.float64]

KIND = "joint_limits"
"""Kind of the network in files of weights (`kinmo.learning.weights`)."""
STEPS = (0.0, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.22, 1.35, 1.5, 1.75, 2.0, 3.0, 4.0)
"""Amounts of travel that the network tells the probabilities of, in scales of the joint."""
NOISE = 0.1
"""Standard deviation of the noise on standardised features in training."""
MAX_FEATURE = 5.0
"""Largest magnitude of a standardised feature."""


class LimitsNetwork(nn.Module):
    """Network for the limits of joints."""

    directed_mean: Tensor
    directed_scale: Tensor
    shared_mean: Tensor
    shared_scale: Tensor

    def __init__(self, directed_features: int, shared_features: int, config: LimitsConfig) -> None:
        super().__init__()
        for name, count in (("directed", directed_features), ("shared", shared_features)):
            self.register_buffer(f"{name}_mean", torch.zeros(count))
            self.register_buffer(f"{name}_scale", torch.ones(count))
        self.words = nn.Embedding(WORD_BUCKETS + 1, config.word_features, padding_idx=WORD_BUCKETS)
        width = config.width
        self.layers = nn.Sequential(
            nn.Linear(2 * directed_features + shared_features + config.word_features, width),
            nn.GELU(),
            nn.Dropout(config.dropout),
            nn.Linear(width, width),
            nn.GELU(),
            nn.Dropout(config.dropout),
        )
        self.travel = nn.Linear(width, len(STEPS))
        self.is_limited = nn.Linear(width, 1)

    def standardize(self, directed: Tensor, shared: Tensor) -> None:
        """Set mean and scale of the features from raw features [J, 2, D] and [J, S] of training joints."""
        for name, values in (("directed", directed.flatten(0, 1)), ("shared", shared)):
            getattr(self, f"{name}_mean").copy_(values.mean(dim=0))
            getattr(self, f"{name}_scale").copy_(values.std(dim=0).clamp_min(1e-3))

    def silence_unknown_words(self, known: Tensor) -> None:
        """Set the embeddings of all buckets to zero, except those of the `known` words."""
        unknown = torch.ones(WORD_BUCKETS + 1, dtype=torch.bool).index_fill(0, known, False)
        with torch.no_grad():
            self.words.weight[unknown] = 0.0

    def forward(self, directed: Tensor, shared: Tensor, words: Tensor) -> tuple[Tensor, Tensor]:
        """Log-probabilities [J, 2, T] of the travel in both senses, and logits [J] that joints have limits.

        Args:
            directed: [J, 2, D] features of both senses.
            shared: [J, S] features of the joints.
            words: [J, W] hashed words; `NO_WORD` fills up the rows.
        """
        directed = ((directed - self.directed_mean) / self.directed_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        shared = ((shared - self.shared_mean) / self.shared_scale).clamp(-MAX_FEATURE, MAX_FEATURE)
        if self.training:
            directed, shared = (values + NOISE * torch.randn_like(values) for values in (directed, shared))
        is_word = words != NO_WORD
        vectors = self.words(torch.where(is_word, words, WORD_BUCKETS))
        named = vectors.sum(dim=1) / is_word.sum(dim=1, keepdim=True).clamp_min(1)
        both = torch.stack([directed.flatten(1), directed.flip(1).flatten(1)], dim=1)
        same = torch.cat([shared, named], dim=1)[:, None].expand(-1, 2, -1)
        hidden = self.layers(torch.cat([both, same], dim=2))
        return self.travel(hidden).float().log_softmax(dim=2), self.is_limited(hidden)[..., 0].float().mean(dim=1)


def limits_loss(travel: Tensor, is_limited: Tensor, true_travel: Tensor) -> Tensor:
    """Cross-entropy of the travel of joints with limits, and of having them.

    Args:
        travel: [J, 2, T] log-probabilities.
        is_limited: [J] logits.
        true_travel: [J, 2] true travel, or `UNLIMITED`.
    """
    limited = (true_travel[:, 0] != UNLIMITED).float()
    each = -(_shares(true_travel.clamp_min(0.0)) * travel).sum(dim=(1, 2)) * limited
    return each.mean() + nn.functional.binary_cross_entropy_with_logits(is_limited, limited)


def _shares(travel: Tensor) -> Tensor:
    """Shares [..., T] of the two nearest `STEPS` in amounts of travel, so that their mean is the amount."""
    steps = torch.tensor(STEPS, dtype=travel.dtype, device=travel.device)
    amount = travel.clamp(max=STEPS[-1])
    upper = torch.searchsorted(steps, amount.contiguous()).clamp(1, len(STEPS) - 1)
    share = (amount - steps[upper - 1]) / (steps[upper] - steps[upper - 1])
    shares = torch.zeros(*travel.shape, len(STEPS), dtype=travel.dtype, device=travel.device)
    return shares.scatter(-1, (upper - 1)[..., None], (1.0 - share)[..., None]).scatter(-1, upper[..., None], share[..., None])


def likely_travel(probabilities: F64) -> F64:
    """The travel [J, 2] in both senses with the highest expected overlap, from the probabilities [J, 2, T] of `STEPS`.

    At least one sense has some travel.
    """
    steps = np.array(STEPS)
    overlap = np.minimum(steps[:, None], steps) / np.maximum(np.maximum(steps[:, None], steps), 1e-12)
    overlap[0, 0] = 1.0
    expected = probabilities @ overlap  # [J, 2, T] over the amounts that may be chosen
    found = steps[expected.argmax(axis=2)]
    moving = probabilities[..., 1:].sum(axis=2)
    farther = moving.argmax(axis=1)
    rows = np.arange(len(found))
    at_least = steps[1:][expected[rows, farther, 1:].argmax(axis=1)]
    found[rows, farther] = np.where(found.max(axis=1) > 0, found[rows, farther], at_least)
    return np.asarray(found)
