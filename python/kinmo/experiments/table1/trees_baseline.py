"""Boosted trees as a baseline, parts given: they see the same features as kinmo's ranking networks, but no names.

A classifier predicts the kind of each body's joint from the features of all bodies. A ranker then picks a candidate joint of
that kind from the features of candidate and body.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, Joint
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.shape_estimate import JointEstimate
from kinmo.evaluation.metrics import MAX_AXIS_ERROR, MAX_LINE_DISTANCE
from kinmo.experiments.table1.trees import KindClassifier, Ranker, fit_kinds, fit_rank
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape, leaf_groups

F64 = NDArray[np.float64]
Rows = NDArray[np.int64]

REST = len(KINDS)
"""Class of a body at rest; the others are the codes of the kinds."""


@dataclass(frozen=True, eq=False)
class TreesBaseline:
    """Trained trees."""

    kinds: KindClassifier
    ranker: Ranker

    def predict(self, shape: PreparedShape, *, kinds_given: bool = False) -> dict[int, JointEstimate]:
        """Predict the joint of every body of an annotated shape.

        Args:
            shape: The shape.
            kinds_given: Use the true kinds, and predict the axes alone.

        Returns:
            Estimates by body, in the normalised frame.
        """
        mobility, boxes = shape.annotation
        features, body_groups = CandidateFeatures.of(shape.candidate_features), _body_groups(shape)
        probabilities = self.kinds.probabilities(_classifier_features(features, list(body_groups.values())), REST + 1)
        found = {}
        for (body, group), chances in zip(body_groups.items(), probabilities, strict=True):
            true = mobility.bodies[body].joint
            kind = int(np.argmax(chances)) if not kinds_given else REST if true is None else true.kind.code
            rows = _rows(features, group, kind)
            if kind == REST or not len(rows):
                found[body] = JointEstimate(None, MotionType.FIXED, float(chances[REST]), source="trees")
                continue
            likelihoods = self.ranker.likelihoods(_ranker_features(features, group, rows))
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
    groups: list[Rows] = []
    right: list[NDArray[np.bool_]] = []
    for shape in shapes:
        mobility, _ = shape.annotation
        features, body_groups = CandidateFeatures.of(shape.candidate_features), _body_groups(shape)
        bodies.append(_classifier_features(features, list(body_groups.values())))
        for body, group in body_groups.items():
            joint = mobility.bodies[body].joint
            classes.append(REST if joint is None else joint.kind.code)
            rows = _rows(features, group, classes[-1])
            if joint is not None and len(rows):
                motions.append(_ranker_features(features, group, rows))
                groups.append(np.full(len(rows), len(classes)))
                right.append(_is_right(features, rows, joint, features.centers[group]))
    kinds = fit_kinds(np.concatenate(bodies), np.array(classes), seed=seed)
    return TreesBaseline(kinds, fit_rank(np.concatenate(motions), np.concatenate(groups), np.concatenate(right), seed=seed))


def _body_groups(shape: PreparedShape) -> Mapping[int, int]:
    """Index in the features of every body that has leaves."""
    place = {leaves: group for group, leaves in enumerate(leaf_groups(shape.leaves_below, shape.body_leaves))}
    return {body: place[leaves] for body, leaves in enumerate(shape.body_leaves) if leaves}


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
