"""The row `trees`, *parts given*: what boosted trees make of the evidence that the `kinmo` method ranks.

A classifier says of every body whether it turns, slides, screws or rests, by the numbers that describe it and the bodies beside
it; of the motions of that kind a ranker picks one, by the numbers of the motion and of the body. Names are shown to neither.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.edge_labels import motion_type
from kinmo.core.joint import KINDS, Joint, MotionType
from kinmo.core.prediction import JointEstimate
from kinmo.evaluation.joint_records import AXIS_WITHIN, LINE_WITHIN
from kinmo.experiments.table1.trees import KindClassifier, Ranker, fit_kinds, fit_rank
from kinmo.features.candidate_features import Evidence
from kinmo.features.prepared_shape import PreparedShape, units_of

F64 = NDArray[np.float64]
Rows = NDArray[np.int64]

"""How evidence numbers the kinds; a body at rest is `REST`."""
REST = len(KINDS)


@dataclass(frozen=True, eq=False)
class TreesBaseline:
    """Trained trees."""

    kinds: KindClassifier
    ranker: Ranker

    def answers(self, shape: PreparedShape, *, kinds_given: bool = False) -> dict[int, JointEstimate]:
        """The joint of every body of an annotated shape by its index, in the normalised frame.

        With `kinds_given` the true kinds are told, and the axes alone are asked for.
        """
        mobility, boxes = shape.annotation
        evidence, units = Evidence.of(shape.evidence), _body_units(shape)
        odds = self.kinds.probabilities(_classed(evidence, list(units.values())), REST + 1)
        found = {}
        for (body, unit), chances in zip(units.items(), odds, strict=True):
            true = mobility.bodies[body].joint
            kind = int(np.argmax(chances)) if not kinds_given else REST if true is None else true.kind.code
            rows = _rows(evidence, unit, kind)
            if kind == REST or not len(rows):
                found[body] = JointEstimate(None, MotionType.FIXED, float(chances[REST]), source="trees")
                continue
            likelihoods = self.ranker.likelihoods(_ranked(evidence, unit, rows))
            best = rows[np.argmax(likelihoods)]
            joint = Joint(KINDS[kind], evidence.directions[best], evidence.pivots[best])
            score = float(chances[kind] * likelihoods.max())
            found[body] = JointEstimate(joint, motion_type(joint, boxes[body], shape.up), score, source="trees")
        return found


def fit_trees(shapes: Iterable[PreparedShape], *, seed: int = 0) -> TreesBaseline:
    """Train on annotated shapes; what is kept of each is its evidence alone. Needs scikit-learn, else raises ImportError."""
    bodies: list[F64] = []
    classes: list[int] = []
    motions: list[F64] = []
    groups: list[Rows] = []
    right: list[NDArray[np.bool_]] = []
    for shape in shapes:
        mobility, _ = shape.annotation
        evidence, units = Evidence.of(shape.evidence), _body_units(shape)
        bodies.append(_classed(evidence, list(units.values())))
        for body, unit in units.items():
            joint = mobility.bodies[body].joint
            classes.append(REST if joint is None else joint.kind.code)
            rows = _rows(evidence, unit, classes[-1])
            if joint is not None and len(rows):
                motions.append(_ranked(evidence, unit, rows))
                groups.append(np.full(len(rows), len(classes)))
                right.append(_right(evidence, rows, joint, evidence.centers[unit]))
    kinds = fit_kinds(np.concatenate(bodies), np.array(classes), seed=seed)
    return TreesBaseline(kinds, fit_rank(np.concatenate(motions), np.concatenate(groups), np.concatenate(right), seed=seed))


def _body_units(shape: PreparedShape) -> Mapping[int, int]:
    """The unit of every body that has leaves."""
    place = {leaves: unit for unit, leaves in enumerate(units_of(shape.leaves_below, shape.body_leaves))}
    return {body: place[leaves] for body, leaves in enumerate(shape.body_leaves) if leaves}


def _rows(evidence: Evidence, unit: int, kind: int) -> Rows:
    """The rows of a unit's motions of one kind."""
    rows = evidence.rows(unit)
    return np.asarray(rows.start + np.flatnonzero(evidence.kinds[rows] == kind))


def _classed(evidence: Evidence, units: list[int]) -> F64:
    """What the classifier sees of the bodies of a shape [B, 4 G]: each, and the range and the mean of all."""
    own = evidence.unit_features[units].astype(float)
    beside = np.concatenate([own.min(axis=0), own.max(axis=0), own.mean(axis=0)])
    return np.concatenate([own, np.broadcast_to(beside, (len(own), len(beside)))], axis=1)


def _ranked(evidence: Evidence, unit: int, rows: Rows) -> F64:
    """What the ranker sees of some motions of a unit [R, F + G]."""
    whole = np.broadcast_to(evidence.unit_features[unit], (len(rows), evidence.unit_features.shape[1]))
    return np.concatenate([evidence.features[rows], whole], axis=1).astype(float)


def _right(evidence: Evidence, rows: Rows, joint: Joint, center: F64) -> NDArray[np.bool_]:
    """Which motions [R] have the axis of `joint` and, but for sliders, its line near the part's `center`."""
    directions, pivots = evidence.directions[rows], evidence.pivots[rows]
    right = np.abs(directions @ joint.direction) >= np.cos(AXIS_WITHIN)
    if joint.has_pivot:
        at_part = joint.pivot + ((center - joint.pivot) @ joint.direction) * joint.direction
        right &= np.linalg.norm(np.cross(at_part - pivots, directions), axis=1) <= LINE_WITHIN
    return np.asarray(right)
