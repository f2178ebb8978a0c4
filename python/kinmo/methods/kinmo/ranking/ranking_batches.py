"""Batches of shape views for the ranking networks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray

from kinmo.methods.kinmo.ranking.ranking_network import RankingBatch
from kinmo.methods.kinmo.ranking.shape_views import ShapeView


def collate_views(
    views: Sequence[ShapeView],
    *,
    rng: np.random.Generator | None = None,
    hide_names: bool = False,
    hide_view: float = 0.0,
    hide_group: float = 0.0,
    hide_category: float = 0.0,
) -> RankingBatch:
    """Join several views to one flat batch.

    Args:
        views: Views of shapes.
        rng: Source of the draws; None: nothing is hidden at random.
        hide_names: Hide all names and categories.
        hide_view: Probability that all names of a view are hidden.
        hide_group: Probability that the names of a group are hidden.
        hide_category: Probability that the category of a view is hidden; 1 hides it without `rng` too.
    """
    candidates: list[NDArray[np.float32]] = []
    groups: list[NDArray[np.float32]] = []
    targets: list[NDArray[np.float64]] = []
    group_of: list[NDArray[np.int64]] = []
    rest: list[float] = []
    view_of: list[int] = []
    slot_of: list[int] = []
    words: list[int] = []
    word_group: list[int] = []
    for number, view in enumerate(views):
        hidden = hide_names or (rng is not None and rng.random() < hide_view)
        hides_category = hide_category >= 1.0 or (hide_category > 0.0 and rng is not None and rng.random() < hide_category)
        for slot, (group, names, target) in enumerate(zip(view.groups, view.words, view.targets, strict=True)):
            rows = view.features.rows(group)
            count = rows.stop - rows.start
            index = len(groups)
            candidates.append(view.features.features[rows])
            groups.append(np.append(view.features.group_features[group], np.float32(view.is_bodies)))
            targets.append(np.zeros(count) if target is None else target)
            rest.append(float(target is None))
            group_of.append(np.full(count, index))
            view_of.append(number)
            slot_of.append(slot)
            if not hidden and not (rng is not None and rng.random() < hide_group):
                shown = names if hides_category else names + view.category
                words.extend(shown)
                word_group.extend([index] * len(shown))
    return RankingBatch(
        torch.from_numpy(np.concatenate(candidates)),
        torch.from_numpy(np.array(groups, np.float32)),
        torch.from_numpy(np.concatenate(group_of)),
        torch.tensor(view_of),
        torch.tensor(slot_of),
        torch.tensor(words, dtype=torch.long),
        torch.tensor(word_group, dtype=torch.long),
        torch.from_numpy(np.concatenate(targets).astype(np.float32)),
        torch.tensor(rest, dtype=torch.float32),
    )
