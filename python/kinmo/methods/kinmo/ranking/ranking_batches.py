"""Batches of shape views for the ranking networks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from kinmo.methods.kinmo.ranking.shape_views import ShapeView


@dataclass(frozen=True)
class RankingBatch:
    """Views of several shapes as flat tensors: C candidates of U groups.

    Attributes:
        candidates ([C, F] float32): Raw features of the candidates.
        groups ([U, G] float32): Raw features of the groups, and of the groups in their view.
        group_of ([C] int64): Group of each candidate.
        view_of ([U] int64): View of each group.
        slot_of ([U] int64): Position of each group in its view.
        words ([W] int64): Hashed words.
        word_group ([W] int64): Group of each word.
        targets ([C] float32): Target probabilities of the candidates.
        rest_targets ([U] float32): Target probabilities of rest.
        weights ([U] float32): Weights of the groups in the loss.
    """

    candidates: Tensor
    groups: Tensor
    group_of: Tensor
    view_of: Tensor
    slot_of: Tensor
    words: Tensor
    word_group: Tensor
    targets: Tensor
    rest_targets: Tensor
    weights: Tensor

    def to(self, device: torch.device) -> RankingBatch:
        """The batch on a device."""
        return RankingBatch(*(values.to(device) for values in vars(self).values()))


def collate_views(
    views: Sequence[ShapeView],
    *,
    rng: np.random.Generator | None = None,
    hide_names: bool = False,
    hide_group: float = 0.0,
    hide_category: float = 0.0,
) -> RankingBatch:
    """Join several views to one flat batch.

    Args:
        views: Views of shapes.
        rng: Source of the draws; None: nothing is hidden at random.
        hide_names: Hide all names and categories.
        hide_group: Probability that the names of a group are hidden.
        hide_category: Probability that the category of a view is hidden; 1 hides it without `rng` too.
    """
    words: list[int] = []
    word_group: list[int] = []
    index = 0
    for view in views:
        hides_category = hide_category >= 1.0 or (hide_category > 0.0 and rng is not None and rng.random() < hide_category)
        for names in view.words:
            if not hide_names:
                hidden = rng is not None and rng.random() < hide_group
                shown = (() if hidden else names) + (() if hides_category else view.category)
                words.extend(shown)
                word_group.extend([index] * len(shown))
            index += 1
    sizes = [len(view.groups) for view in views]
    counts = [count for view in views for count in view.features.counts(view.groups)]
    groups = [np.column_stack([view.features.group_features[list(view.groups)], view.context]) for view in views]
    targets = [target for view in views for target in view.targets]
    weights = np.concatenate([view.weights for view in views])
    return RankingBatch(
        torch.from_numpy(np.concatenate([v.features.features[v.features.rows(group)] for v in views for group in v.groups])),
        torch.from_numpy(np.concatenate(groups)),
        torch.from_numpy(np.repeat(np.arange(len(counts)), counts)),
        torch.from_numpy(np.repeat(np.arange(len(views)), sizes)),
        torch.from_numpy(np.concatenate([np.arange(size) for size in sizes])),
        torch.tensor(words, dtype=torch.long),
        torch.tensor(word_group, dtype=torch.long),
        torch.from_numpy(np.concatenate(targets).astype(np.float32)),
        torch.tensor([1.0 - target.sum() for target in targets], dtype=torch.float32),
        torch.from_numpy(weights.astype(np.float32)),
    )
