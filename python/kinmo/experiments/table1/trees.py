"""The bar of a simple learner: boosted trees on hand-made features (the extra `trees`)."""

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
"""Of a tree. There are hundreds of bodies to class, and dozens of times as many candidates to rank."""


def library_version() -> str | None:
    """The version of scikit-learn, which is not imported for this; None where it is not installed."""
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
    """Tells which of a body's candidates are likely to be right."""

    model: Any

    def likelihoods(self, features: F64) -> F64:
        """How likely each of R candidates is to be right, [R] in [0, 1], from `features` [R, F]."""
        return _column(self.model, features, 1)


def fit_rank(features: F64, groups: I64, right: NDArray[np.bool_], *, seed: int = 0, iterations: int = ITERATIONS) -> Ranker:
    """Learn which of a body's candidates are right.

    `features` [R, F] (NaN where unknown), `groups` [R] bodies, `right` [R]. Every body weighs the same, however many
    candidates it has.
    """
    _, inverse, counts = np.unique(groups, return_inverse=True, return_counts=True)
    return Ranker(
        _classifier(seed, iterations, RANK_LEAVES).fit(features, right.astype(int), sample_weight=1.0 / counts[inverse])
    )


@dataclass(frozen=True, eq=False)
class KindClassifier:
    """Says which class a body is of."""

    model: Any

    def probabilities(self, features: F64, classes: int) -> F64:
        """[N, classes] for N bodies; 0 for a class that was never seen."""
        found = np.zeros((len(features), classes))
        found[:, self.model.classes_] = self.model.predict_proba(features)
        return found


def fit_kinds(features: F64, kinds: I64, *, seed: int = 0, iterations: int = ITERATIONS) -> KindClassifier:
    """Learn the class [N] of N bodies (such as CoarseType) from `features` [N, F]."""
    return KindClassifier(_classifier(seed, iterations, KIND_LEAVES).fit(features, kinds))


def _column(model: Any, features: F64, label: int) -> F64:
    """The likelihood of a class; 0 if training had none of it."""
    where = np.flatnonzero(model.classes_ == label)
    return np.asarray(model.predict_proba(features)[:, where[0]]) if len(where) else np.zeros(len(features))
