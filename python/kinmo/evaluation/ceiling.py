"""The rows that frame a table: the best that the candidates allow, and what needs no learning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.box import Box
from kinmo.evaluation import metrics
from kinmo.evaluation.records import AXIS_WITHIN, LINE_WITHIN, annotation
from kinmo.ground_truth import motion_type
from kinmo.joint import Joint, JointKind, MotionType
from kinmo.prediction import JointEstimate
from kinmo.prepared import PreparedShape
from kinmo.shape import Vector

F64 = NDArray[np.float64]

SMALL = 0.2
"""Of the object's diagonal: a part with a smaller box is pressed, not turned."""
FLAT = 0.3
"""Of the middle extent: a part with a smaller thinnest extent is a panel."""
NEAREST = 0.05
"""The share of a part's points that counts as its contact with the rest."""
OFF_CENTRE = 0.5
"""Of the half extent: contact farther from the middle than this is contact at an edge."""


def ceiling(truth: PreparedShape, candidates: Mapping[int, tuple[F64, F64]]) -> dict[int, JointEstimate]:
    """The best candidate of every movable body of `truth`, its true kind known.

    `candidates` holds directions [K, 3] (unit) and pivots [K, 3] by body, in the normalised frame. Best is the one whose
    worse error, axis over 5 degrees or line at the part over 0.05 diagonals, is smallest. It has no range. A body without
    candidates gets no answer.
    """
    mobility, boxes = annotation(truth)
    best = {}
    for index, body in mobility.movable():
        true = body.joint
        directions, pivots = candidates.get(index, (np.zeros((0, 3)), np.zeros((0, 3))))
        if true is None or not len(directions):
            continue
        joints = [Joint(true.kind, d, p) for d, p in zip(directions, pivots, strict=True)]
        joint = min(joints, key=lambda found: _error(true, found, boxes[index].center))
        best[index] = JointEstimate(joint, truth.body_types[index], 1.0, source="ceiling")
    return best


def _error(true: Joint, found: Joint, middle: Vector) -> float:
    axis = metrics.axis_error(true.direction, found.direction) / AXIS_WITHIN
    return max(axis, metrics.line_distance_at_part(true, found, middle) / LINE_WITHIN) if true.has_pivot else axis


def without_learning(truth: PreparedShape) -> dict[int, JointEstimate]:
    """Answers to all bodies of `truth`, given its bodies but no joint, by a rule that anybody can check.

    - The largest body stands still. - A small body is pressed: it slides along the direction in which its contact with the
    rest is thinnest. - A panel turns about one of its edges: the edge nearest the contact where it touches along one, and
    else (a closed door, which
      touches all around) the more upright pair's edge that is farther from the middle of the object.
    - Everything else slides along the box axis that points most away from the middle of the object, horizontally.
    """
    mobility, boxes = annotation(truth)
    clouds = [_cloud(truth, body.leaves) for body in mobility.bodies]
    sizes = [float(np.linalg.norm(boxes[index].half_extents)) for index in range(len(clouds))]
    answers = {}
    for index, cloud in enumerate(clouds):
        rest = [other for place, other in enumerate(clouds) if place != index]
        if sizes[index] == max(sizes) or not rest:
            answers[index] = JointEstimate(None, MotionType.FIXED, 1.0, source="rule")
            continue
        joint = _rule(boxes[index], truth.up, *_contact(cloud, np.concatenate(rest)))
        answers[index] = JointEstimate(joint, motion_type(joint, boxes[index], truth.up), 1.0, source="rule")
    return answers


def _cloud(truth: PreparedShape, leaves: Sequence[int]) -> F64:
    """Points and normals [N, 6] of some leaves."""
    rows = [truth.leaves.index(leaf) for leaf in leaves]
    return np.concatenate([truth.leaf_points[rows], truth.leaf_normals[rows]], axis=2).reshape(-1, 6).astype(float)


def _contact(cloud: F64, rest: F64) -> tuple[Vector, Vector]:
    """Middle [3] of the points of `cloud` nearest to `rest`, and the direction [3] in which most of `rest` faces there."""
    distances, nearest = cKDTree(rest[:, :3]).query(cloud[:, :3])
    chosen = np.argsort(distances, kind="stable")[: max(3, int(NEAREST * len(cloud)))]
    facing = np.linalg.svd(rest[nearest[chosen], 3:], full_matrices=False)[2][0]
    return cloud[chosen, :3].mean(axis=0), facing


def _rule(box: Box, up: Vector, contact: Vector, facing: Vector) -> Joint:
    order = np.argsort(box.half_extents)
    if 2.0 * np.linalg.norm(box.half_extents) < SMALL:
        return Joint(JointKind.PRISMATIC, facing, box.center)
    if box.half_extents[order[0]] < FLAT * box.half_extents[order[1]]:
        return _panel(box.axes[order[1:]], box.half_extents[order[1:]], box.center, contact, up)
    away = box.center - np.dot(box.center, up) * up
    axis = box.axes[np.argmax(np.abs(box.axes @ away) - np.abs(box.axes @ up))]
    return Joint(JointKind.PRISMATIC, axis, box.center)


def _panel(axes: F64, extents: F64, center: Vector, contact: Vector, up: Vector) -> Joint:
    """A hinge along an edge of the panel that `axes` [2, 3] span with half `extents` [2]."""
    offsets = axes @ (contact - center) / extents
    across = int(np.argmax(np.abs(offsets)))
    if abs(offsets[across]) > OFF_CENTRE:
        side = np.sign(offsets[across])
    else:
        across = int(np.argmin(np.abs(axes @ up)))
        side = 1.0 if np.dot(axes[across], center) >= 0 else -1.0
    return Joint(JointKind.REVOLUTE, axes[1 - across], center + side * extents[across] * axes[across])


def choices(groups: NDArray[np.int64], values: F64) -> dict[int, int]:
    """For every group (a body), the row [R] with the largest value; `groups` and `values` are [R]."""
    order: Sequence[int] = np.lexsort((-values, groups)).tolist()
    best: dict[int, int] = {}
    for row in order:
        best.setdefault(int(groups[row]), row)
    return best
