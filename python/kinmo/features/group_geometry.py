"""Geometry of one group of leaves relative to the other leaves: boxes, contact region and surroundings.

A *group* is a set of leaves that is treated as one rigid part: a node of the hierarchy or a body.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.oriented_box import Box
from kinmo.features.round_pieces import RoundPieces, joint_pieces
from kinmo.features.shape_geometry import TOUCHING, ShapeGeometry

F64 = NDArray[np.float64]

SURFACE_POINTS = 1024
"""Surface samples per group."""
CONTACT_POINTS = 128
"""Number of samples nearest to the other leaves that form the contact region."""
CONTACT_SCALE = 0.01
"""Distance, in diagonals, over which the weight of a contact point falls by a factor e."""
PROTRUSION_SCALE = 0.01
"""Distance, in diagonals, over which the weight of a protruding point falls by a factor e."""
MEETING = 1e-4
"""Distance, in diagonals, below which two surfaces meet."""


@dataclass(frozen=True, eq=False)
class GroupGeometry:
    """One group of leaves relative to the leaves that stay when it moves, in the normalised frame.

    Attributes:
        leaves: Positions of the group's leaves.
        rest: Positions of the leaves that stay.
        riders: Positions of the leaves that sit on the group and move with it.
        minimum: Minimum-volume box.
        aligned: Box along the object's own axes.
        points ([n, 3]): Surface samples.
        normals ([n, 3]): Unit normals at the samples.
        distances ([n]): Distances of the samples to the leaves that stay; 1 if there are none.
        contact ([m, 3]): Samples nearest to the leaves that stay.
        contact_weights ([m]): Weights of the contact points; they sum to one.
        toward ([m, 3]): Unit vectors from the leaves that stay to the contact points; 0 if there are none.
        own_round: Round pieces of the group.
        neighbour_round: Round pieces of the leaves that it touches.
    """

    leaves: tuple[int, ...]
    rest: list[int]
    riders: list[int]
    minimum: Box
    aligned: Box
    points: F64
    normals: F64
    distances: F64
    contact: F64
    contact_weights: F64
    toward: F64
    own_round: RoundPieces
    neighbour_round: RoundPieces

    @cached_property
    def sorted_axes(self) -> F64:
        """Axes [3, 3] of the minimum-volume box, the longest first."""
        return np.asarray(self.minimum.axes[np.argsort(-self.minimum.half_extents)])

    @cached_property
    def half_diagonal(self) -> float:
        """Half the diagonal of the minimum-volume box."""
        return max(float(np.linalg.norm(self.minimum.half_extents)), 1e-6)

    @cached_property
    def protrusion(self) -> F64:
        """Mean [3] of the points farthest from the leaves that stay, such as a handle; the middle if the group is even."""
        weights = np.exp((self.distances - self.distances.max()) / PROTRUSION_SCALE)
        return np.asarray(weights @ self.points / weights.sum())

    @cached_property
    def mean_toward(self) -> F64:
        """Weighted mean [3] of `toward`."""
        return np.asarray(self.contact_weights @ self.toward)


def contact_weights(distances: F64) -> F64:
    """Weights [m] of contact points by their distances [m] to the other leaves, ascending; they sum to one."""
    weights = np.exp(-(distances - distances[0]) / CONTACT_SCALE)
    return np.asarray(weights / weights.sum())


def group_geometries(shape: ShapeGeometry, groups: Sequence[Sequence[int]]) -> list[GroupGeometry]:
    """Boxes, contact and surroundings of every group (positions of its leaves)."""
    leaf_lists = [list(group) for group in groups]
    minimum = [Box(*box) for box in zip(*_core.fit_boxes(shape.meshes, leaf_lists), strict=True)]
    aligned = [Box(*box) for box in zip(*_core.fit_aligned_boxes(shape.meshes, shape.frame, leaf_lists), strict=True)]
    return [_group_geometry(shape, *each) for each in zip(leaf_lists, minimum, aligned, strict=True)]


def _group_geometry(shape: ShapeGeometry, leaves: list[int], minimum: Box, aligned: Box) -> GroupGeometry:
    points, normals = shape.surface(leaves, SURFACE_POINTS)
    rest, riders = shape.surroundings(leaves)
    if rest:
        distances, nearest, rest_normals = _core.closest_points(shape.meshes, rest, points)
    else:
        distances, nearest, rest_normals = np.ones(len(points)), points, np.zeros_like(points)
    order = np.argsort(distances)[:CONTACT_POINTS]
    near, gap, normal = nearest[order], distances[order, None], rest_normals[order]
    # Surfaces that meet have no direction between them: the other leaf's normal replaces it, pointing to the group.
    points_to_group = np.sum(normal * (aligned.center - near), axis=1, keepdims=True) >= 0
    toward_normal = np.where(points_to_group, normal, -normal)
    toward = np.where(gap < MEETING, toward_normal, (points[order] - near) / np.maximum(gap, MEETING))
    weights = contact_weights(gap[:, 0])
    touched = np.asarray(shape.touching[leaves].any(axis=0))
    pieces = joint_pieces(shape.round_pieces, shape.meshes, leaves, touched, TOUCHING, weights @ points[order])
    return GroupGeometry(
        tuple(leaves), rest, riders, minimum, aligned, points, normals, distances,
        points[order], weights, toward if rest else np.zeros_like(toward), *pieces,
    )  # fmt: skip
