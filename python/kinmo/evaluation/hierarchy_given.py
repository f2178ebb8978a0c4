"""Evaluation with the hierarchy given: a method gets only the part hierarchy, as from users, and predicts bodies and joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from kinmo.core.links import links_of
from kinmo.core.motion_types import CoarseType
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.evaluation.joint_records import ShapeScore, false_alarm, joint_record, missed_record
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]

MIN_IOU = 0.5  # smallest overlap (intersection over union of areas) of two bodies that match


def score_hierarchy_given(
    truth: PreparedShape, prediction: ShapeEstimate, *, penetrations: Mapping[int, float] | None = None
) -> ShapeScore:
    """Score predicted bodies and joints.

    Bodies are matched one to one by the area of the leaves they share, without junk. Predicted bodies that are fixed to each
    other count as one. A true joint is found if its body matches a body that moves. A predicted body that moves is a false
    alarm if it does not match a true body that moves. The prediction is in the frame and the lengths of the file. Penetrations
    (`PenetrationMeter`) are by index of the predicted body.
    """
    mobility, _ = truth.annotation
    links, frame = links_of(prediction.mobility), Normalisation(truth.center, truth.diagonal)
    shared, iou = _overlap(truth, [body.leaves for body in mobility.bodies], [link.leaves for link in links])
    link_of_body = one_to_one(iou)
    records, found_links = [], set()
    for index, body in mobility.movable():
        link = link_of_body.get(index)
        moving = None if link is None else links[link].body
        if link is None or moving is None:
            records.append(missed_record(truth, index))
            continue
        found_links.add(link)
        record = joint_record(truth, index, frame.estimate(prediction.estimates[moving][0]))
        parent_ok = body.parent is not None and int(np.argmax(shared[body.parent])) == links[link].parent
        penetration = None if penetrations is None else penetrations.get(moving)
        records.append(replace(record, parent_ok=parent_ok, penetration=penetration))
    wrong = [link.body for index, link in enumerate(links) if link.body is not None and index not in found_links]
    alarms = tuple(false_alarm(prediction.mobility.bodies[body].name, prediction.estimates[body][0]) for body in wrong)
    has_fine_types = not any(isinstance(ranked[0].type, CoarseType) for ranked in prediction.estimates if ranked)
    return ShapeScore(truth.id, truth.category, tuple(records), alarms, has_fine_types)


def _overlap(truth: PreparedShape, bodies: Sequence[Sequence[int]], others: Sequence[Sequence[int]]) -> tuple[F64, F64]:
    """Areas [K, B] that K and B bodies share, and their intersections over unions. Bodies are leaves; junk has no area."""
    mobility, _ = truth.annotation
    leaves = np.array(truth.leaves)
    areas = np.where(np.isin(leaves, list(mobility.junk)), 0.0, truth.leaf_areas)
    first, second = (np.array([np.isin(leaves, members) for members in groups], float) for groups in (bodies, others))
    shared = (first * areas) @ second.T
    union = (first @ areas)[:, None] + (second @ areas)[None, :] - shared
    return shared, np.divide(shared, union, out=np.zeros_like(shared), where=union > 0)


def one_to_one(iou: F64) -> dict[int, int]:
    """The column of every matched row of `iou` [K, B]: the assignment of overlaps of at least `MIN_IOU` with largest total."""
    allowed = np.where(iou >= MIN_IOU, iou, 0.0)
    pairs = zip(*linear_sum_assignment(allowed, maximize=True), strict=True)
    return {int(row): int(column) for row, column in pairs if allowed[row, column] > 0}
