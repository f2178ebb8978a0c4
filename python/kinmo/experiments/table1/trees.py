"""Boosted trees of scikit-learn (the extra `trees`): a classifier and a ranker."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

ITERATIONS = 150
LEARNING_RATE = 0.1
KIND_LEAVES, RANK_LEAVES = 8, 31
"""Largest numbers of leaves of a tree: there are many more candidates to rank than bodies to classify."""


def library_version() -> str | None:
    """Version of scikit-learn, without importing it; None if it is not installed."""
    try:
        return version("scikit-learn")
    except PackageNotFoundError:
        return None


def _classifier(seed: int, iterations: int, leaves: int) -> Any:
    try:
        from sklearn.ensemble import HistGradientBoostingClassifier
    except ImportError as error:
        raise ImportError("the trees row needs scikit-learn: pip install 'kinmo[trees]'") from error
    return HistGradientBoostingClassifier(
        max_iter=iterations, learning_rate=LEARNING_RATE, max_leaf_nodes=leaves, early_stopping=False, random_state=seed
    )


@dataclass(frozen=True, eq=False)
class Ranker:
    """Ranks the candidate joints of a body."""

    model: Any

    def likelihoods(self, features: F64) -> F64:
        """Probability [R] of each candidate to be right, from its features [R, F]."""
        return _column(self.model, features, 1)


def fit_rank(features: F64, groups: I64, right: NDArray[np.bool_], *, seed: int = 0, iterations: int = ITERATIONS) -> Ranker:
    """Fit a ranker. Every body has the same weight, however many candidates it has.

    Args:
        features: Features [R, F] of candidates; NaN where unknown.
        groups: Body [R] of each candidate.
        right: [R], True for right candidates.
        seed: Seed of the trees.
        iterations: Number of trees.
    """
    _, inverse, counts = np.unique(groups, return_inverse=True, return_counts=True)
    return Ranker(
        _classifier(seed, iterations, RANK_LEAVES).fit(features, right.astype(int), sample_weight=1.0 / counts[inverse])
    )


@dataclass(frozen=True, eq=False)
class KindClassifier:
    """Predicts the class of a body."""

    model: Any

    def probabilities(self, features: F64, classes: int) -> F64:
        """Probabilities [N, classes] for N bodies; 0 for a class that was never seen."""
        found = np.zeros((len(features), classes))
        found[:, self.model.classes_] = self.model.predict_proba(features)
        return found


def fit_kinds(features: F64, kinds: I64, *, seed: int = 0, iterations: int = ITERATIONS) -> KindClassifier:
    """Fit a classifier of N bodies from features [N, F] and classes [N]."""
    return KindClassifier(_classifier(seed, iterations, KIND_LEAVES).fit(features, kinds))


def _column(model: Any, features: F64, label: int) -> F64:
    """Probability of a class; 0 if training had none of it."""
    where = np.flatnonzero(model.classes_ == label)
    return np.asarray(model.predict_proba(features)[:, where[0]]) if len(where) else np.zeros(len(features))
