"""A shape as its parts see each other: what a part touches, what hangs on it, and what stays when it moves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from kinmo import _core
from kinmo.core.box import Box
from kinmo.features.candidate_lines import object_frame
from kinmo.features.round_pieces import RoundPieces, round_pieces_of

F64 = NDArray[np.float64]

TOUCHING = 0.008
"""Leaves nearer than this hang together."""
HANGING_AREA = 0.5
"""What hangs on a part moves with it if it has less than this share of the part's surface."""
SURFACE_POINTS = 1024
CONTACT_POINTS = 128
CONTACT_SCALE = 0.01
PROTRUSION_SCALE = 0.01
MEETING = 1e-4
"""Below this distance surfaces meet."""


@dataclass(frozen=True, eq=False)
class Scene:
    """The leaves of one shape in the normalised frame.

    `points` and `normals` [L, n, 3], `areas` [L], `frame` [3, 3] (rows: the object's own axes, `up` last), `extents` [2, 3]
    (low and high along them), `touching` [L, L] bool.
    """

    meshes: _core.Meshes
    points: F64
    normals: F64
    areas: F64
    frame: F64
    extents: F64
    touching: NDArray[np.bool_]

    @classmethod
    def of(cls, meshes: _core.Meshes, points: NDArray[np.float32], normals: NDArray[np.float32], areas: F64, up: F64) -> Scene:
        """The scene of leaves with surface samples `points` and `normals` [L, n, 3] in random order."""
        few = normals[:, :128].astype(float)
        weights = np.repeat(areas / few.shape[1], few.shape[1])
        frame = object_frame(few.reshape(-1, 3), weights, up)
        placed = points.reshape(-1, 3).astype(float) @ frame.T
        pairs = _core.part_distances(meshes, max_distance=TOUCHING)[0]
        touching = np.zeros((len(areas), len(areas)), bool)
        touching[pairs[:, 0], pairs[:, 1]] = touching[pairs[:, 1], pairs[:, 0]] = True
        extents = np.stack([placed.min(axis=0), placed.max(axis=0)])
        return cls(meshes, points.astype(float), normals.astype(float), areas, frame, extents, touching)

    @property
    def up(self) -> F64:
        up: F64 = self.frame[2]
        return up

    @cached_property
    def middle(self) -> F64:
        """Middle [3] of the object's box along its own axes."""
        middle: F64 = self.extents.mean(axis=0) @ self.frame
        return middle

    @cached_property
    def centroids(self) -> F64:
        """Centroids [L, 3] of the leaves' surfaces."""
        centroids: F64 = self.points.mean(axis=1)
        return centroids

    @cached_property
    def round_pieces(self) -> RoundPieces:
        return RoundPieces.of(self.meshes)

    def surface(self, leaves: Sequence[int], count: int) -> tuple[F64, F64]:
        """About `count` points of some leaves and their normals, in proportion to area."""
        area = self.areas[list(leaves)]
        share = area / area.sum() if area.sum() > 0 else np.full(len(area), 1.0 / len(area))
        takes = np.minimum(np.ceil(share * count).astype(int), self.points.shape[1])
        points = np.concatenate([self.points[leaf, :n] for leaf, n in zip(leaves, takes, strict=True)])
        normals = np.concatenate([self.normals[leaf, :n] for leaf, n in zip(leaves, takes, strict=True)])
        return points, normals

    def surroundings(self, unit: Sequence[int]) -> tuple[list[int], list[int]]:
        """Leaves that stay when the unit moves, and its *riders*: those that hang on it alone, such as a knob on a door."""
        others = np.setdiff1d(np.arange(len(self.areas)), np.asarray(unit))
        if len(others) == 0:
            return [], []
        _, component = connected_components(self.touching[others][:, others], directed=False)
        mass = np.bincount(component, self.areas[others])
        hangs = np.zeros(len(mass), bool)
        hangs[component[self.touching[others][:, np.asarray(unit)].any(axis=1)]] = True
        hangs[np.argmax(mass)] = False
        hangs &= mass < HANGING_AREA * self.areas[list(unit)].sum()
        return others[~hangs[component]].tolist(), others[hangs[component]].tolist()


@dataclass(frozen=True, eq=False)
class Unit:
    """One part seen against the rest of its shape.

    `points`, `normals` [n, 3] sample its surface and `distances` [n] are theirs to the rest (1 where there is no rest).
    `contact` [m, 3] are the points nearest to the rest, with `contact_weights` [m] that sum to one and `toward` [m, 3], the
    unit vectors from the rest to them. `minimum` is the part's minimum-volume box, `aligned` that along the object's own axes.
    `own_round` are its round pieces and `next_round` those of what it touches.
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
    next_round: RoundPieces

    @cached_property
    def sorted_axes(self) -> F64:
        """Axes [3, 3] of the minimum-volume box, the longest first."""
        axes: F64 = self.minimum.axes[np.argsort(-self.minimum.half_extents)]
        return axes

    @cached_property
    def half_diagonal(self) -> float:
        return max(float(np.linalg.norm(self.minimum.half_extents)), 1e-6)

    @cached_property
    def protrusion(self) -> F64:
        """Where the part sticks out of the rest: the mean [3] of its farthest points, such as a handle's.

        A part that sticks out evenly has it in its middle.
        """
        weights = np.exp((self.distances - self.distances.max()) / PROTRUSION_SCALE)
        protrusion: F64 = weights @ self.points / weights.sum()
        return protrusion

    @cached_property
    def mean_toward(self) -> F64:
        toward: F64 = self.contact_weights @ self.toward
        return toward


def see_units(scene: Scene, units: Sequence[Sequence[int]]) -> list[Unit]:
    """Boxes, contact and surroundings of every unit."""
    groups = [list(unit) for unit in units]
    minimum = [Box(*box) for box in zip(*_core.fit_boxes(scene.meshes, groups), strict=True)]
    aligned = [Box(*box) for box in zip(*_core.fit_aligned_boxes(scene.meshes, scene.frame, groups), strict=True)]
    return [_see(scene, *each) for each in zip(groups, minimum, aligned, strict=True)]


def _see(scene: Scene, leaves: list[int], minimum: Box, aligned: Box) -> Unit:
    points, normals = scene.surface(leaves, SURFACE_POINTS)
    rest, riders = scene.surroundings(leaves)
    if rest:
        distances, nearest, rest_normals = _core.closest_points(scene.meshes, rest, points)
    else:
        distances, nearest, rest_normals = np.ones(len(points)), points, np.zeros_like(points)
    order = np.argsort(distances)[:CONTACT_POINTS]
    near, gap, normal = nearest[order], distances[order, None], rest_normals[order]
    weights = np.exp(-(gap[:, 0] - gap[0, 0]) / CONTACT_SCALE)
    # Where the surfaces meet there is no direction between them: the rest's normal stands in, on the side of the part.
    faces_part = np.sum(normal * (aligned.center - near), axis=1, keepdims=True) >= 0
    facing = np.where(faces_part, normal, -normal)
    toward = np.where(gap < MEETING, facing, (points[order] - near) / np.maximum(gap, MEETING))
    weights /= weights.sum()
    touched = np.asarray(scene.touching[leaves].any(axis=0))
    rounds = round_pieces_of(scene.round_pieces, scene.meshes, leaves, touched, TOUCHING, weights @ points[order])
    return Unit(
        tuple(leaves), rest, riders, minimum, aligned, points, normals, distances,
        points[order], weights, toward if rest else np.zeros_like(toward), *rounds,
    )  # fmt: skip
