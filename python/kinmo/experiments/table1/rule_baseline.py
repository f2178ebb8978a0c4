"""Baseline without learning: a rule that gives joints by size, contact and position.

- The largest body stands still.
- A small body is pressed: it slides along the direction in which its contact with the rest is thinnest.
- A panel turns about the edge along which its contact lies. A closed door touches all around. It turns about one of its two
  more upright edges, the one farther from the middle of the object.
- Every other body slides along the box axis that points most away from the middle of the object, horizontally.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.normalisation import Normalisation
from kinmo.core.oriented_box import Box
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.core.vector import Vector
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]

MAX_BUTTON_SIZE = 0.2  # diagonal (of the object's) below which a part is pressed rather than turned
MAX_PANEL_THICKNESS = 0.3  # thickness of a panel at most, as a share of its middle extent
CONTACT_SHARE = 0.05  # share of a part's points that counts as its contact with the rest
EDGE_OFFSET = 0.5  # distance from the middle (in half extents) beyond which contact is at an edge


def rule_joints(truth: PreparedShape) -> dict[int, JointEstimate]:
    """Estimates for all bodies of an annotated shape from its bodies alone, in the normalised frame."""
    mobility, boxes = truth.annotation
    estimates = _estimates(truth, truth.body_leaves, [boxes[index] for index in range(len(mobility.bodies))])
    return dict(enumerate(estimates))


def rule_prediction(shape: PreparedShape) -> ShapeEstimate:
    """ShapeEstimate from the hierarchy alone, in the shape's own frame.

    The bodies are the children of the first part from the root down that has several; all are attached to the largest.
    """
    children: dict[int, list[int]] = {}
    for node, parent in enumerate(shape.parents):
        children.setdefault(parent, []).append(node)
    nodes = [0]
    while len(nodes) == 1 and nodes[0] in children:
        nodes = children[nodes[0]]
    found = _estimates(shape, [shape.leaves_below[node] for node in nodes], [shape.symmetric_boxes[node] for node in nodes])
    still = next(index for index, estimate in enumerate(found) if estimate.joint is None)
    frame = Normalisation(shape.center, shape.diagonal)
    estimates = [frame.undo_estimate(estimate) for estimate in found]
    bodies = [
        Body(
            index,
            shape.part_names[node],
            tuple(shape.leaves[place] for place in shape.leaves_below[node]),
            None if index == still else still,
            estimate.joint,
        )
        for index, (node, estimate) in enumerate(zip(nodes, estimates, strict=True))
    ]
    ranked = tuple((estimate,) for estimate in estimates)
    return ShapeEstimate(shape.id, shape.category, Mobility(tuple(bodies)), ranked, tuple(estimates), "rule")


def _estimates(shape: PreparedShape, bodies: Sequence[Sequence[int]], boxes: Sequence[Box]) -> list[JointEstimate]:
    """Estimates for bodies (positions of their leaves) with these boxes; at least one of them rests."""
    clouds = [_cloud(shape, leaves) for leaves in bodies]
    sizes = [float(np.linalg.norm(box.half_extents)) for box in boxes]
    estimates = []
    for index, (cloud, box) in enumerate(zip(clouds, boxes, strict=True)):
        rest = [other for place, other in enumerate(clouds) if place != index]
        if sizes[index] == max(sizes) or not rest:
            estimates.append(JointEstimate(None, MotionType.FIXED, 1.0, source="rule"))
            continue
        joint = _rule(box, shape.up, *_contact(cloud, np.concatenate(rest)))
        estimates.append(JointEstimate(joint, motion_type(joint, box, shape.up), 1.0, source="rule"))
    return estimates


def _cloud(shape: PreparedShape, leaves: Sequence[int]) -> F64:
    """Points and normals [N, 6] of the leaves at some positions."""
    rows = list(leaves)
    return np.concatenate([shape.leaf_points[rows], shape.leaf_normals[rows]], axis=2).reshape(-1, 6).astype(float)


def _contact(cloud: F64, rest: F64) -> tuple[Vector, Vector]:
    """Middle [3] of the points of `cloud` nearest to `rest`, and the main normal [3] of `rest` there."""
    distances, nearest = cKDTree(rest[:, :3]).query(cloud[:, :3])
    chosen = np.argsort(distances, kind="stable")[: max(3, int(CONTACT_SHARE * len(cloud)))]
    facing = np.linalg.svd(rest[nearest[chosen], 3:], full_matrices=False)[2][0]
    return cloud[chosen, :3].mean(axis=0), facing


def _rule(box: Box, up: Vector, contact: Vector, facing: Vector) -> Joint:
    order = np.argsort(box.half_extents)
    if 2.0 * np.linalg.norm(box.half_extents) < MAX_BUTTON_SIZE:
        return Joint(JointKind.PRISMATIC, facing, box.center)
    if box.half_extents[order[0]] < MAX_PANEL_THICKNESS * box.half_extents[order[1]]:
        return _panel(box.axes[order[1:]], box.half_extents[order[1:]], box.center, contact, up)
    away = box.center - np.dot(box.center, up) * up
    axis = box.axes[np.argmax(np.abs(box.axes @ away) - np.abs(box.axes @ up))]
    return Joint(JointKind.PRISMATIC, axis, box.center)


def _panel(axes: F64, extents: F64, center: Vector, contact: Vector, up: Vector) -> Joint:
    """A hinge along an edge of the panel that `axes` [2, 3] span with half `extents` [2]."""
    offsets = axes @ (contact - center) / extents
    across = int(np.argmax(np.abs(offsets)))
    if abs(offsets[across]) > EDGE_OFFSET:
        side = np.sign(offsets[across])
    else:
        across = int(np.argmin(np.abs(axes @ up)))
        side = 1.0 if np.dot(axes[across], center) >= 0 else -1.0
    return Joint(JointKind.REVOLUTE, axes[1 - across], center + side * extents[across] * axes[across])
