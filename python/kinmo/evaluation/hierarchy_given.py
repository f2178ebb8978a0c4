"""The second setting, which is a user's: only the part hierarchy is given, and the bodies are predicted too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from kinmo.core.joint import CoarseType
from kinmo.core.links import links_of
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.evaluation.joint_records import ShapeScore, false_alarm, joint_record, missed_record
from kinmo.features.prepared_shape import PreparedShape

LEAST_IOU = 0.5
"""Of leaf areas: bodies that overlap less are not the same."""


def hierarchy_given(
    truth: PreparedShape, prediction: Prediction, *, penetrations: Mapping[int, float] | None = None
) -> ShapeScore:
    """Score a prediction (in the frame and the lengths of the file) for the annotated shape `truth`.

    Bodies are matched one to one by the areas of the leaves they share, junk left out; predicted bodies that are fastened to
    each other count as one. A true joint is found if its body is matched to a body that moves; moving bodies that are not
    matched to a moving one are false alarms. `penetrations` are by index of the predicted body.
    """
    mobility, _ = truth.annotation
    links = links_of(prediction.mobility)
    overlap = overlap_of(truth, [body.leaves for body in mobility.bodies], [link.leaves for link in links])
    matched = match_bodies(overlap)
    records, right = [], set()
    for index, body in mobility.movable():
        place = matched.get(index)
        moving = None if place is None else links[place].body
        if place is None or moving is None:
            records.append(missed_record(truth, index))
            continue
        right.add(place)
        record = joint_record(truth, index, _normalised(_answer(prediction, moving), truth))
        parent_ok = body.parent is not None and int(np.argmax(overlap.shared[body.parent])) == links[place].parent
        penetration = None if penetrations is None else penetrations.get(moving)
        records.append(replace(record, parent_ok=parent_ok, penetration=penetration))
    wrong = [link.body for place, link in enumerate(links) if link.body is not None and place not in right]
    alarms = tuple(false_alarm(prediction.mobility.bodies[body].name, _answer(prediction, body)) for body in wrong)
    is_fine = not any(isinstance(answers[0].type, CoarseType) for answers in prediction.estimates if answers)
    return ShapeScore(truth.id, truth.category, tuple(records), alarms, is_fine)


@dataclass(frozen=True, eq=False)
class Overlap:
    """What K true bodies and B predicted ones share: areas [K, B] in squared diagonals, and their union."""

    shared: NDArray[np.float64]
    union: NDArray[np.float64]


def overlap_of(truth: PreparedShape, bodies: Sequence[Sequence[int]], others: Sequence[Sequence[int]]) -> Overlap:
    """Overlap of two sets of bodies, each given by its leaves (indices of parts); junk leaves have no area."""
    mobility, _ = truth.annotation
    leaves = np.array(truth.leaves)
    areas = np.where(np.isin(leaves, list(mobility.junk)), 0.0, truth.leaf_areas)
    first, second = (np.array([np.isin(leaves, members) for members in groups], float) for groups in (bodies, others))
    shared = (first * areas) @ second.T
    return Overlap(shared, (first @ areas)[:, None] + (second @ areas)[None, :] - shared)


def match_bodies(overlap: Overlap) -> dict[int, int]:
    """The predicted body of every matched true body: the best one-to-one assignment of overlaps of at least `LEAST_IOU`."""
    iou = np.divide(overlap.shared, overlap.union, out=np.zeros_like(overlap.shared), where=overlap.union > 0)
    wanted = np.where(iou >= LEAST_IOU, iou, 0.0)
    pairs = zip(*linear_sum_assignment(wanted, maximize=True), strict=True)
    return {int(true): int(predicted) for true, predicted in pairs if wanted[true, predicted] > 0}


def _answer(prediction: Prediction, body: int) -> JointEstimate:
    """The answer that became the joint of a moving body."""
    return prediction.estimates[body][0]


def _normalised(estimate: JointEstimate, truth: PreparedShape) -> JointEstimate:
    """An estimate in the file's frame, in the normalised frame of `truth`."""
    if estimate.joint is None:
        return estimate
    return replace(estimate, joint=Normalisation(truth.center, truth.diagonal).joint(estimate.joint))
