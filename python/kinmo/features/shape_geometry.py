"""Geometry of all leaves of one shape: meshes, surface samples, contact, and the object's own axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.round_pieces import RoundPieces

F64 = NDArray[np.float64]

TOUCHING = 0.008
"""Distance, in diagonals, below which two leaves touch."""
MAX_RIDER_AREA = 0.5
"""Riders are smaller than this share of the surface of the group they sit on."""
FRAME_NORMALS = 128
"""Normals per leaf that the object's own axes are estimated from."""
FLAT_FACES = np.radians(6.0)
"""Largest angle between the normal of a flat face and the estimated horizontal axes, in radians."""


def object_frame(normals: F64, weights: F64, up: F64) -> F64:
    """The object's own axes [3, 3] as unit rows: two horizontal ones, and `up` last.

    The horizontal axes are the directions that most surface faces, counted modulo quarter turns. They turn with the object. The
    surface is given by unit normals [N, 3] and their areas `weights` [N].
    """
    east = np.cross(up, [0.0, 0.0, 1.0] if abs(up[2]) < 0.9 else [1.0, 0.0, 0.0])
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    x, y = normals @ east, normals @ north
    flatness = x * x + y * y
    angle = np.arctan2(y, x)
    mass = weights * flatness * flatness
    turn = np.angle(np.sum(mass * np.exp(4j * angle))) / 4.0
    # Round surfaces pull the mean. The median of the normals near it is the direction of the flat faces.
    offset = np.angle(np.exp(4j * (angle - turn))) / 4.0
    near = np.abs(offset) < FLAT_FACES
    if np.any(near & (mass > 0)):
        order = np.argsort(offset[near])
        cumulative = np.cumsum(mass[near][order])
        turn += offset[near][order][np.searchsorted(cumulative, 0.5 * cumulative[-1])]
    first = np.cos(turn) * east + np.sin(turn) * north
    return np.stack([first, np.cross(up, first), up])


@dataclass(frozen=True, eq=False)
class ShapeGeometry:
    """The L leaves of one shape in the normalised frame.

    Attributes:
        meshes: Meshes of the leaves.
        points ([L, n, 3]): Surface samples in random order.
        normals ([L, n, 3]): Unit normals at the samples.
        areas ([L]): Surface areas.
        frame ([3, 3]): The object's own axes (rows, `up` last).
        extents ([2, 3]): Lowest and highest coordinates along `frame`.
        touching ([L, L] bool): Pairs of leaves closer than `TOUCHING`.
    """

    meshes: _core.Meshes
    points: F64
    normals: F64
    areas: F64
    frame: F64
    extents: F64
    touching: NDArray[np.bool_]

    @classmethod
    def of(
        cls, meshes: _core.Meshes, points: NDArray[np.float32], normals: NDArray[np.float32], areas: F64, up: F64
    ) -> ShapeGeometry:
        """Geometry of leaves from their meshes, samples and areas (see the attributes), and the unit vector `up` [3]."""
        few = normals[:, :FRAME_NORMALS].astype(float)
        weights = np.repeat(areas / few.shape[1], few.shape[1])
        frame = object_frame(few.reshape(-1, 3), weights, up)
        placed = points.reshape(-1, 3).astype(float) @ frame.T
        pairs = _core.part_distances(meshes, max_distance=TOUCHING)[0]
        touching = np.zeros((len(areas), len(areas)), bool)
        touching[pairs[:, 0], pairs[:, 1]] = touching[pairs[:, 1], pairs[:, 0]] = True
        extents = np.stack([placed.min(axis=0), placed.max(axis=0)])
        return cls(meshes, points.astype(float), normals.astype(float), areas, frame, extents, touching)

    @classmethod
    def of_prepared(cls, shape: PreparedShape, meshes: _core.Meshes) -> ShapeGeometry:
        """Geometry of a prepared shape, from its samples and the meshes of its leaves (`prepared_shape.leaf_meshes`)."""
        return cls.of(meshes, shape.leaf_points, shape.leaf_normals, shape.leaf_areas, shape.up)

    @property
    def up(self) -> F64:
        """Upward unit vector [3]."""
        return np.asarray(self.frame[2])

    @cached_property
    def middle(self) -> F64:
        """Middle [3] of the object's box along its own axes."""
        return np.asarray(self.extents.mean(axis=0) @ self.frame)

    @cached_property
    def centroids(self) -> F64:
        """Centroids [L, 3] of the leaves' surfaces."""
        return np.asarray(self.points.mean(axis=1))

    @cached_property
    def round_pieces(self) -> RoundPieces:
        """Round pieces of all leaves."""
        return RoundPieces.of(self.meshes)

    def surface(self, leaves: Sequence[int], count: int) -> tuple[F64, F64]:
        """About `count` samples of some leaves in proportion to area: points [n, 3] and unit normals [n, 3]."""
        area = self.areas[list(leaves)]
        share = area / area.sum() if area.sum() > 0 else np.full(len(area), 1.0 / len(area))
        counts = np.minimum(np.ceil(share * count).astype(int), self.points.shape[1])
        points = np.concatenate([self.points[leaf, :n] for leaf, n in zip(leaves, counts, strict=True)])
        normals = np.concatenate([self.normals[leaf, :n] for leaf, n in zip(leaves, counts, strict=True)])
        return points, normals

    def surroundings(self, group: Sequence[int]) -> tuple[list[int], list[int]]:
        """Positions of the leaves that stay when a group of leaves moves, and of its riders.

        Riders are small leaves that touch the group and nothing else that stays, such as a knob on a door.
        """
        members = np.asarray(group)
        is_other = np.ones(len(self.areas), bool)
        is_other[members] = False
        others = np.flatnonzero(is_other)
        if len(others) == 0:
            return [], []
        component = self._components(is_other)[others]
        mass = np.bincount(component, self.areas[others])
        rides = np.zeros(len(mass), bool)
        rides[component[np.asarray(self.touching[:, members].any(axis=1))[others]]] = True
        rides[np.argmax(mass)] = False
        rides &= mass < MAX_RIDER_AREA * self.areas[list(group)].sum()
        return others[~rides[component]].tolist(), others[rides[component]].tolist()

    @cached_property
    def _touched(self) -> list[set[int]]:
        """Positions of the leaves that each leaf touches."""
        return [set(np.flatnonzero(row).tolist()) for row in self.touching]

    def _components(self, chosen: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Number [L] of the connected component of each of the `chosen` [L] leaves by touch; -1 for the others.

        The components are numbered by their first leaves.
        """
        component = [-1] * len(chosen)
        leaves = np.flatnonzero(chosen).tolist()
        waiting, count = set(leaves), 0
        for start in leaves:
            if start not in waiting:
                continue
            waiting.remove(start)
            stack = [start]
            while stack:
                leaf = stack.pop()
                component[leaf] = count
                found = self._touched[leaf] & waiting
                waiting -= found
                stack.extend(found)
            count += 1
        return np.array(component, np.int64)
