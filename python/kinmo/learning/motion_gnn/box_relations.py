"""Relation of two oriented boxes: the features of an edge of the part pair graph (paper, section 3.2)."""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from kinmo.features.prepared_shape import Boxes

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

STATES = ("inside", "around", "apart", "crossing")
"""Overlap of the moving box with the reference box: inside it, around it, hardly any overlap, or anything else."""

SIDES = ("right", "left", "top", "bottom", "front", "back")
"""Face of the reference box that is nearest to the centre of the moving box, in the object's frame."""

INSIDE_SHARE, APART_SHARE = 0.9, 0.1
"""Share of a box's volume from which on it counts as inside the other, and below which the two are apart."""
GRID = 6
"""Points along each side of the grid that estimates shared volumes."""
PAIRS_AT_ONCE = 8192
"""Number of box pairs in one batch, which bounds the memory."""
_AXIS_ORDERS = np.array(list(permutations(range(3))))


def object_axes(up: F64) -> F64:
    """Unit rows right, up, front [3, 3] of the object's frame, for the direction `up` [3] of any length.

    For y up these are the x, y and z axes of the file.
    """
    up = up / np.linalg.norm(up)
    front = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    front = front - (front @ up) * up
    front /= np.linalg.norm(front)
    # np.cross takes twenty times as long for two vectors, and this runs for every variant of every shape
    right = up[[1, 2, 0]] * front[[2, 0, 1]] - up[[2, 0, 1]] * front[[1, 2, 0]]
    return np.array([right, up, front])


def canonical_boxes(boxes: Boxes, up: F64) -> Boxes:
    """The same boxes with their axes ordered and oriented like the object's right, up and front, as nearly as possible.

    A box has no first axis: the same box can be written in 24 ways. Without this step a network would have to learn them all.
    """
    cosines = boxes.axes @ object_axes(up).T  # [N, axis of the box, axis of the object]
    fit = np.abs(cosines)[:, _AXIS_ORDERS, np.arange(3)].sum(-1)
    order = _AXIS_ORDERS[np.argmax(fit, axis=1)]
    rows = np.arange(len(boxes))[:, None]
    signs = np.where(cosines[rows, order, np.arange(3)] < 0, -1.0, 1.0)
    return Boxes(boxes.centers, boxes.axes[rows, order] * signs[..., None], boxes.half_extents[rows, order])


def box_states(boxes: Boxes, edges: I64) -> I64:
    """Overlap of the moving and the reference box of every edge [E, 2], as indices into `STATES` [E].

    It is estimated with a grid of points in each box.
    """
    steps = (np.arange(GRID) + 0.5) / GRID * 2 - 1
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), -1).reshape(-1, 3)
    points = boxes.centers[:, None] + (grid * boxes.half_extents[:, None]) @ boxes.axes

    def share_inside(inner: I64, outer: I64) -> F64:
        local = (points[inner] - boxes.centers[outer][:, None]) @ boxes.axes[outer].transpose(0, 2, 1)
        reach = boxes.half_extents[outer] + 1e-9
        return (np.abs(local) <= reach[:, None]).all(-1).mean(-1)  # type: ignore[no-any-return]

    states = np.empty(len(edges), np.int64)
    for start in range(0, len(edges), PAIRS_AT_ONCE):
        some = slice(start, start + PAIRS_AT_ONCE)
        moving, reference = edges[some].T
        inside, around = share_inside(moving, reference), share_inside(reference, moving)
        conditions = [inside >= INSIDE_SHARE, around >= INSIDE_SHARE, inside <= APART_SHARE]
        states[some] = np.select(conditions, [0, 1, 2], default=3)
    return states


def box_sides(boxes: Boxes, edges: I64) -> I64:
    """Face of the reference box that is nearest to the centre of the moving box, for every edge [E, 2].

    The boxes are those of `canonical_boxes`, the results [E] indices into `SIDES`.
    """
    moving, reference = edges.T
    faces = boxes.axes[reference] * boxes.half_extents[reference][..., None]
    faces = np.stack([faces, -faces], axis=2).reshape(-1, 6, 3)
    offset = boxes.centers[moving] - boxes.centers[reference]
    return np.asarray(np.argmin(np.linalg.norm(faces - offset[:, None], axis=-1), axis=1), np.int64)
