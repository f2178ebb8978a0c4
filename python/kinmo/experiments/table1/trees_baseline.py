"""Boosted trees of scikit-learn (the extra `trees`) as a baseline, parts given.

They see the same features as kinmo's ranking networks, but no names. A classifier predicts the kind of each body's joint from
the features of all bodies. A ranker then picks a candidate joint of that kind from the features of candidate and body.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, Joint
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.shape_estimate import JointEstimate
from kinmo.evaluation.metrics import MAX_AXIS_ERROR, MAX_LINE_DISTANCE
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]
Rows = NDArray[np.int64]

REST = len(KINDS)  # class of a body at rest; the others are the codes of the kinds
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


def classifier(seed: int, leaves: int, iterations: int = ITERATIONS) -> Any:
    """Boosted trees before training. Raises ImportError without scikit-learn."""
    try:
        from sklearn.ensemble import HistGradientBoostingClassifier
    except ImportError as error:
        raise ImportError("the trees row needs scikit-learn: pip install 'kinmo[trees]'") from error
    return HistGradientBoostingClassifier(
        max_iter=iterations, learning_rate=LEARNING_RATE, max_leaf_nodes=leaves, early_stopping=False, random_state=seed
    )


def probabilities(model: Any, features: F64, classes: int) -> F64:
    """Probabilities [N, classes] of trained trees for features [N, F]; 0 for a class that was never seen."""
    found = np.zeros((len(features), classes))
    found[:, model.classes_] = model.predict_proba(features)
    return found


@dataclass(frozen=True, eq=False)
class TreesBaseline:
    """Trained trees: a classifier of bodies, and a ranker of candidates as right (1) or wrong (0)."""

    kinds: Any
    ranker: Any

    def predict(self, shape: PreparedShape, *, kinds_given: bool = False) -> dict[int, JointEstimate]:
        """Predict the joint of every body of an annotated shape, in the normalised frame.

        With `kinds_given`, the true kinds are used, and the axes alone are predicted.
        """
        mobility, boxes = shape.annotation
        features = CandidateFeatures.of(shape.candidate_features)
        body_groups = _body_groups(shape, features)
        chances_of_kinds = probabilities(self.kinds, _classifier_features(features, list(body_groups.values())), REST + 1)
        found = {}
        for (body, group), chances in zip(body_groups.items(), chances_of_kinds, strict=True):
            true = mobility.bodies[body].joint
            kind = int(np.argmax(chances)) if not kinds_given else REST if true is None else true.kind.code
            rows = _rows(features, group, kind)
            if kind == REST or not len(rows):
                found[body] = JointEstimate(None, MotionType.FIXED, float(chances[REST]), source="trees")
                continue
            likelihoods = probabilities(self.ranker, _ranker_features(features, group, rows), 2)[:, 1]
            best = rows[np.argmax(likelihoods)]
            joint = Joint(KINDS[kind], features.directions[best], features.pivots[best])
            score = float(chances[kind] * likelihoods.max())
            found[body] = JointEstimate(joint, motion_type(joint, boxes[body], shape.up), score, source="trees")
        return found


def fit_trees(shapes: Iterable[PreparedShape], *, seed: int = 0) -> TreesBaseline:
    """Train on annotated shapes. Raises ImportError without scikit-learn."""
    bodies: list[F64] = []
    classes: list[int] = []
    motions: list[F64] = []
    weights: list[F64] = []
    right: list[NDArray[np.bool_]] = []
    for shape in shapes:
        mobility, _ = shape.annotation
        features = CandidateFeatures.of(shape.candidate_features)
        body_groups = _body_groups(shape, features)
        bodies.append(_classifier_features(features, list(body_groups.values())))
        for body, group in body_groups.items():
            joint = mobility.bodies[body].joint
            classes.append(REST if joint is None else joint.kind.code)
            rows = _rows(features, group, classes[-1])
            if joint is not None and len(rows):
                motions.append(_ranker_features(features, group, rows))
                weights.append(np.full(len(rows), 1.0 / len(rows)))  # every body has the same weight
                right.append(_is_right(features, rows, joint, features.centers[group]))
    kinds = classifier(seed, KIND_LEAVES).fit(np.concatenate(bodies), np.array(classes))
    ranker = classifier(seed, RANK_LEAVES)
    ranker.fit(np.concatenate(motions), np.concatenate(right).astype(int), sample_weight=np.concatenate(weights))
    return TreesBaseline(kinds, ranker)


def _body_groups(shape: PreparedShape, features: CandidateFeatures) -> Mapping[int, int]:
    """Index in the features of every body that has leaves."""
    return {body: features.group_of[leaves] for body, leaves in enumerate(shape.body_leaves) if leaves}


def _rows(features: CandidateFeatures, group: int, kind: int) -> Rows:
    """Rows of a body's candidate joints of one kind."""
    rows = features.rows(group)
    return np.asarray(rows.start + np.flatnonzero(features.kinds[rows] == kind))


def _classifier_features(features: CandidateFeatures, body_groups: list[int]) -> F64:
    """Features [B, 4 G] for the classifier: those of each body, and minimum, maximum and mean over all bodies."""
    own = features.group_features[body_groups].astype(float)
    beside = np.concatenate([own.min(axis=0), own.max(axis=0), own.mean(axis=0)])
    return np.concatenate([own, np.broadcast_to(beside, (len(own), len(beside)))], axis=1)


def _ranker_features(features: CandidateFeatures, group: int, rows: Rows) -> F64:
    """Features [R, F + G] for the ranker: those of candidates and of their body."""
    whole = np.broadcast_to(features.group_features[group], (len(rows), features.group_features.shape[1]))
    return np.concatenate([features.features[rows], whole], axis=1).astype(float)


def _is_right(features: CandidateFeatures, rows: Rows, joint: Joint, center: F64) -> NDArray[np.bool_]:
    """Mask [R] of the candidates with the axis of `joint` and, except for sliders, its line near the part's `center`."""
    directions, pivots = features.directions[rows], features.pivots[rows]
    right = np.abs(directions @ joint.direction) >= np.cos(MAX_AXIS_ERROR)
    if joint.has_pivot:
        at_part = joint.pivot + ((center - joint.pivot) @ joint.direction) * joint.direction
        right &= np.linalg.norm(np.cross(at_part - pivots, directions), axis=1) <= MAX_LINE_DISTANCE
    return np.asarray(right)
