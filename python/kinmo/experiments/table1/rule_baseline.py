"""The row without learning: joints by a rule that anybody can check.

- The largest body stands still.
- A small body is pressed: it slides along the direction in which its contact with the rest is thinnest.
- A panel turns about one of its edges: the edge nearest the contact where it touches along one, and else (a closed door, which
  touches all around) the more upright pair's edge that is farther from the middle of the object.
- Everything else slides along the box axis that points most away from the middle of the object, horizontally.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.box import Box
from kinmo.core.edge_labels import motion_type
from kinmo.core.joint import Joint, JointKind, MotionType
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.core.vector import Vector
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]

SMALL = 0.2
"""Of the object's diagonal: a part with a smaller box is pressed, not turned."""
FLAT = 0.3
"""Of the middle extent: a part with a smaller thinnest extent is a panel."""
NEAREST = 0.05
"""The share of a part's points that counts as its contact with the rest."""
OFF_CENTRE = 0.5
"""Of the half extent: contact farther from the middle than this is contact at an edge."""


def without_learning(truth: PreparedShape) -> dict[int, JointEstimate]:
    """Answers to all bodies of `truth`, given its bodies but no joint, in the normalised frame."""
    mobility, boxes = truth.annotation
    answers = _answers(truth, truth.body_leaves, [boxes[index] for index in range(len(mobility.bodies))])
    return dict(enumerate(answers))


def segmented_without_learning(shape: PreparedShape) -> Prediction:
    """A mobility for a shape of which only the hierarchy is given.

    From the root down, the first part that has several parts is taken for the object: those are its bodies, all on the largest.
    """
    children: dict[int, list[int]] = {}
    for node, parent in enumerate(shape.parents):
        children.setdefault(parent, []).append(node)
    nodes = [0]
    while len(nodes) == 1 and nodes[0] in children:
        nodes = children[nodes[0]]
    found = _answers(shape, [shape.leaves_below[node] for node in nodes], [shape.symmetric_boxes[node] for node in nodes])
    still = next(index for index, answer in enumerate(found) if answer.joint is None)
    frame = Normalisation(shape.center, shape.diagonal)
    answers = [frame.undo_estimate(answer) for answer in found]
    bodies = [
        Body(
            index,
            shape.part_names[node],
            tuple(shape.leaves[place] for place in shape.leaves_below[node]),
            None if index == still else still,
            answer.joint,
        )
        for index, (node, answer) in enumerate(zip(nodes, answers, strict=True))
    ]
    estimates = tuple((answer,) for answer in answers)
    return Prediction(shape.id, shape.category, Mobility(tuple(bodies)), estimates, tuple(answers), "rule")


def _answers(shape: PreparedShape, bodies: Sequence[Sequence[int]], boxes: Sequence[Box]) -> list[JointEstimate]:
    """What the rule says of bodies (positions of their leaves) with these boxes; at least one of them stands still."""
    clouds = [_cloud(shape, leaves) for leaves in bodies]
    sizes = [float(np.linalg.norm(box.half_extents)) for box in boxes]
    answers = []
    for index, (cloud, box) in enumerate(zip(clouds, boxes, strict=True)):
        rest = [other for place, other in enumerate(clouds) if place != index]
        if sizes[index] == max(sizes) or not rest:
            answers.append(JointEstimate(None, MotionType.FIXED, 1.0, source="rule"))
            continue
        joint = _rule(box, shape.up, *_contact(cloud, np.concatenate(rest)))
        answers.append(JointEstimate(joint, motion_type(joint, box, shape.up), 1.0, source="rule"))
    return answers


def _cloud(shape: PreparedShape, leaves: Sequence[int]) -> F64:
    """Points and normals [N, 6] of the leaves at some positions."""
    rows = list(leaves)
    return np.concatenate([shape.leaf_points[rows], shape.leaf_normals[rows]], axis=2).reshape(-1, 6).astype(float)


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
