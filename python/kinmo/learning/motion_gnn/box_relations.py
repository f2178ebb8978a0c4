"""How one oriented box lies to another: the features of an edge (paper, section 3.2)."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from kinmo.features.prepared_shape import Boxes

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

STATES = ("inside", "around", "apart", "crossing")
"""How much of a box lies in the other: nearly all, all of the other in it, hardly any, something between."""

SIDES = ("right", "left", "top", "bottom", "front", "back")
"""The face of the reference box that the moving box's centre is nearest to, by the object's frame."""

MOSTLY, HARDLY = 0.9, 0.1
GRID = 6
PAIRS_AT_ONCE = 8192
POSE_FEATURES = 18
_ORDERS = np.array(list(permutations(range(3))))


def object_axes(up: F64) -> F64:
    """The object's frame [3, 3]: unit rows right, up, front. For y up these are x, y, z of the file."""
    up = up / np.linalg.norm(up)
    front = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    front = front - (front @ up) * up
    front /= np.linalg.norm(front)
    # np.cross takes twenty times as long for two vectors, and this is asked of every variant of every shape
    right = up[[1, 2, 0]] * front[[2, 0, 1]] - up[[2, 0, 1]] * front[[1, 2, 0]]
    return np.array([right, up, front])


def canonical(boxes: Boxes, up: F64) -> Boxes:
    """The same boxes with their axes in the order and the sense of the object's right, up and front, as nearly as they can be.

    A box does not say which of its axes is the first; without this a network would have to learn all 24 ways to write it.
    """
    cosines = boxes.axes @ object_axes(up).T  # [N, axis of the box, axis of the object]
    fit = np.abs(cosines)[:, _ORDERS, np.arange(3)].sum(-1)
    order = _ORDERS[np.argmax(fit, axis=1)]
    rows = np.arange(len(boxes))[:, None]
    sense = np.where(cosines[rows, order, np.arange(3)] < 0, -1.0, 1.0)
    return Boxes(boxes.centers, boxes.axes[rows, order] * sense[..., None], boxes.half_extents[rows, order])


def box_states(boxes: Boxes, edges: I64) -> I64:
    """Index into STATES [E] for each (moving, reference) pair, by the share of a grid of points of one box inside the other."""
    steps = (np.arange(GRID) + 0.5) / GRID * 2 - 1
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    points = boxes.centers[:, None] + (grid * boxes.half_extents[:, None]) @ boxes.axes

    def share_inside(inner: I64, outer: I64) -> F64:
        local = (points[inner] - boxes.centers[outer][:, None]) @ boxes.axes[outer].transpose(0, 2, 1)
        reach = boxes.half_extents[outer] + 1e-9
        return (np.abs(local) <= reach[:, None]).all(-1).mean(-1)  # type: ignore[no-any-return]

    states = np.empty(len(edges), np.int64)
    for start in range(0, len(edges), PAIRS_AT_ONCE):
        moving, reference = edges[start : start + PAIRS_AT_ONCE].T
        inside, around = share_inside(moving, reference), share_inside(reference, moving)
        states[start : start + PAIRS_AT_ONCE] = np.select(
            [inside >= MOSTLY, around >= MOSTLY, inside <= HARDLY], [0, 1, 2], default=3
        )
    return states


def box_sides(boxes: Boxes, edges: I64) -> I64:
    """Index into SIDES [E] for each (moving, reference) pair of `canonical` boxes."""
    moving, reference = edges.T
    faces = boxes.axes[reference] * boxes.half_extents[reference][..., None]
    faces = np.stack([faces, -faces], axis=2).reshape(-1, 6, 3)
    offset = boxes.centers[moving] - boxes.centers[reference]
    return np.asarray(np.argmin(np.linalg.norm(faces - offset[:, None], axis=-1), axis=1), np.int64)


def relative_poses(boxes: Boxes, edges: I64) -> F64:
    """[E, POSE_FEATURES]: the moving box as the reference box sees it.

    Offset of the centres along the reference's axes, as a length and in its half extents (bounded), rotation between the axes,
    and the ratios of sizes (bounded logarithm).
    """
    moving, reference = edges.T
    frame = boxes.axes[reference]
    offset = np.einsum("eij,ej->ei", frame, boxes.centers[moving] - boxes.centers[reference])
    turn = frame @ boxes.axes[moving].transpose(0, 2, 1)
    smallest = 1e-3
    relative = np.tanh(offset / (boxes.half_extents[reference] + smallest))
    ratio = np.tanh(np.log((boxes.half_extents[moving] + smallest) / (boxes.half_extents[reference] + smallest)) / 2)
    return np.concatenate([offset, relative, turn.reshape(-1, 9), ratio], axis=1)
