"""Simple rankers of candidate joints that take the place of trained networks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinmo.methods.kinmo.ranking.shape_views import ShapeView


@dataclass
class UniformRanker:
    """All candidates of a group are equally probable. Group i rests with probability `rest[i]`, or 0.8 without `rest`."""

    rest: Sequence[float] | None = None

    def probabilities(self, view: ShapeView) -> tuple[list[np.ndarray], np.ndarray]:
        counts = view.features.counts(view.groups)
        rest = np.full(len(counts), 0.8) if self.rest is None else np.array(self.rest)
        return [np.full(count, (1.0 - still) / count) for count, still in zip(counts, rest, strict=True)], rest


class FeatureRanker:
    """Probabilities that depend on all features, in an arbitrary way."""

    def probabilities(self, view: ShapeView) -> tuple[list[np.ndarray], np.ndarray]:
        features = view.features
        scores = [np.exp(np.sin(features.features[features.rows(group)].astype(float)).sum(axis=1)) for group in view.groups]
        rest = 0.5 + 0.4 * np.sin(features.group_features[list(view.groups)].astype(float).sum(axis=1))
        return [(1.0 - still) * each / each.sum() for each, still in zip(scores, rest, strict=True)], rest
