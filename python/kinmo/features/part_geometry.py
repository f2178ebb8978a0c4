"""Boxes, interaction regions and candidate lines of groups of leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from kinmo import _core
from kinmo.core.box import Box
from kinmo.core.mobility import Body, descendants
from kinmo.features.candidate_lines import Lines, Source, candidate_lines
from kinmo.features.prepared_shape import PreparedShape

F64 = NDArray[np.float64]

REGION_SAMPLES = 128
"""Samples a leaf that interaction regions are taken of."""
CONTACT_POINTS = 96
CONTACT_SCALE = 0.01
POINTS_OF_REST = 4096


@dataclass(frozen=True, eq=False)
class PartGeometry:
    """One body of a tree, in the normalised frame.

    `leaves` are places in `PreparedShape.leaves` of its own leaves, `moving` those and its descendants', `reference` those of
    the body it is attached to (all that rests, if it is attached to nothing), `obstacles` all that do not move with it.
    """

    leaves: list[int]
    moving: list[int]
    reference: list[int]
    obstacles: list[int]


def part_geometries(shape: PreparedShape, bodies: Sequence[Body]) -> list[PartGeometry]:
    """The leaves that matter to each of `bodies`."""
    place = {leaf: position for position, leaf in enumerate(shape.leaves)}
    own = [[place[leaf] for leaf in body.leaves] for body in bodies]
    parents = [body.parent for body in bodies]
    found = []
    for index, body in enumerate(bodies):
        moving = sorted(leaf for below in descendants(parents, index) for leaf in own[below])
        obstacles = sorted(set(range(len(shape.leaves))) - set(moving))
        reference = own[body.parent] if body.parent is not None else obstacles
        found.append(PartGeometry(own[index], moving, reference, obstacles))
    return found


def symmetric_box(shape: PreparedShape, leaves: Sequence[int], meshes: _core.Meshes | None = None) -> Box:
    """The symmetry-aligned box of some leaves: that of the part or body that they are, or else one fitted to them.

    Without `meshes` (of the leaves, in the normalised frame) it is fitted to the convex hull of their samples.
    """
    wanted = tuple(sorted(leaves))
    for part, below in enumerate(shape.leaves_below):
        if tuple(sorted(below)) == wanted:
            return shape.symmetric_boxes[part]
    if shape.mobility is not None and shape.body_boxes is not None:
        place = {leaf: position for position, leaf in enumerate(shape.leaves)}
        for index, body in enumerate(shape.mobility.bodies):
            if tuple(sorted(place[leaf] for leaf in body.leaves)) == wanted:
                return shape.body_boxes[index]
    surface, groups = (meshes, [list(wanted)]) if meshes is not None else (_hull(shape, wanted), None)
    centers, axes, half_extents = _core.fit_symmetric_boxes(surface, groups)[:3]
    return Box(centers[0], axes[0], half_extents[0])


def _hull(shape: PreparedShape, leaves: Sequence[int]) -> _core.Meshes:
    points = shape.leaf_points[list(leaves)].reshape(-1, 3).astype(np.float64)
    try:
        faces = ConvexHull(points).simplices
    except QhullError:  # flat or thin: any triangles through all points have the same box
        faces = np.stack([np.zeros(len(points) - 2), np.arange(1, len(points) - 1), np.arange(2, len(points))], axis=1)
    return _core.Meshes([points], [np.ascontiguousarray(faces, np.uint32)])


def interaction_centroid(shape: PreparedShape, part: PartGeometry) -> F64 | None:
    """Centroid [3] of the interaction region with the reference (Hu 2015); None where there is no reference."""
    if not part.reference or not part.leaves:
        return None
    points = np.ascontiguousarray(shape.leaf_points[:, :REGION_SAMPLES])
    regions = _core.interaction_regions(points, np.array([[0, 1]], np.uint32), [part.leaves, part.reference])
    return np.asarray(regions.centroids[0])


def lines_of(shape: PreparedShape, part: PartGeometry, meshes: _core.Meshes) -> Lines:
    """All candidate axes: minimum and aligned box, contact with what rests, symmetry (`hypotheses.candidate_lines`)."""
    groups = [part.leaves]
    minimum = Box(*(values[0] for values in _core.fit_boxes(meshes, groups)[:3]))
    aligned = Box(*(values[0] for values in _core.fit_aligned_boxes(meshes, np.eye(3), groups)[:3]))
    _, kinds, _, points, directions, _ = _core.find_symmetries(meshes, groups)
    axes = np.stack([points[kinds == 1], directions[kinds == 1]], axis=1)
    own = shape.leaf_points[part.leaves].reshape(-1, 3).astype(np.float64)
    if part.obstacles:
        rest = shape.leaf_points[part.obstacles].reshape(-1, 3)
        distances = cKDTree(rest[:: max(1, len(rest) // POINTS_OF_REST)]).query(own)[0]
    else:
        distances = np.ones(len(own))
    nearest = np.argsort(distances, kind="stable")[:CONTACT_POINTS]
    weights = np.exp(-(distances[nearest] - distances[nearest[0]]) / CONTACT_SCALE)
    return candidate_lines(minimum, aligned, own[nearest], weights / weights.sum(), {Source.SYMMETRY_AXIS: axes})
