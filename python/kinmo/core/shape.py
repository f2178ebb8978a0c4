"""A 3D object as a hierarchy of parts, in the frame and the length unit of its source file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.look import Look, join_looks
from kinmo.core.mobility import Mobility
from kinmo.core.vector import Vector

Y_UP: tuple[float, float, float] = (0.0, 1.0, 0.0)
Z_FRONT: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    Attributes:
        vertices: [V, 3] float64, in the length unit of the file.
        faces: [F, 3] uint32, indices into `vertices`.
        look: materials, texture coordinates, colours and normals of the faces. None if the mesh has none.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]
    look: Look | None = None

    @property
    def triangles(self) -> NDArray[np.float64]:
        """The corners [F, 3, 3] of all faces."""
        return self.vertices[self.faces]

    @property
    def face_areas(self) -> NDArray[np.float64]:
        """Areas [F] of all faces."""
        first, second, third = np.moveaxis(self.triangles, 1, 0)
        return np.asarray(0.5 * np.linalg.norm(np.cross(second - first, third - first), axis=1))

    @property
    def corners(self) -> NDArray[np.float64]:
        """The vertices [U, 3] that faces use, each once, in their order."""
        return self.vertices[self._is_used]

    @property
    def compact(self) -> Mesh:
        """The same faces without the vertices that no face uses."""
        used = self._is_used
        return Mesh(self.vertices[used], (np.cumsum(used) - 1)[self.faces].astype(np.uint32), self.look)

    def part(self, chosen: NDArray[Any]) -> Mesh:
        """Some faces, without the vertices that they do not use. `chosen` has their indices in any order, or True for them."""
        used, places = np.unique(self.faces[chosen], return_inverse=True)
        look = None if self.look is None else self.look.of_faces(chosen)
        return Mesh(self.vertices[used], places.reshape(-1, 3).astype(np.uint32), look)

    @property
    def flipped(self) -> Mesh:
        """The same faces seen from their other side: their corners are in reverse order."""
        return Mesh(self.vertices, self.faces[:, ::-1], None if self.look is None else self.look.flipped)

    @property
    def bare(self) -> Mesh:
        """The mesh without its look."""
        return Mesh(self.vertices, self.faces)

    @property
    def _is_used(self) -> NDArray[np.bool_]:
        used = np.zeros(len(self.vertices), bool)
        used[self.faces] = True
        return used

    def rotated(self, rotation: NDArray[np.float64]) -> Mesh:
        """The mesh in a frame that `rotation` [3, 3] rotates the present frame to."""
        return self.moved(rotation, 0.0)

    def moved(self, linear: NDArray[np.float64], offset: NDArray[np.float64] | float) -> Mesh:
        """The mesh moved by a linear map [3, 3] and then an offset [3]. If the map mirrors, faces look inwards."""
        look = None if self.look is None else self.look.moved(linear)
        return Mesh(self.vertices @ linear.T + offset, self.faces, look)


def join(*meshes: Mesh) -> Mesh:
    """One mesh with the vertices and faces of all given meshes. It is empty if none is given."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)]).astype(np.uint32)
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
    nothing = np.zeros((0, 3))
    return Mesh(
        np.concatenate([nothing, *(mesh.vertices for mesh in meshes)]),
        np.concatenate([nothing.astype(np.uint32), *faces]),
        join_looks([mesh.look for mesh in meshes], [mesh.triangles for mesh in meshes]),
    )


def bounds_of(meshes: Iterable[Mesh]) -> tuple[Vector, Vector]:
    """Smallest and largest corner [3] of the axis-aligned bounding box of the faces of some meshes (at least one face)."""
    used = [mesh.corners for mesh in meshes]
    return np.min([v.min(axis=0) for v in used], axis=0), np.max([v.max(axis=0) for v in used], axis=0)


@dataclass(frozen=True, eq=False)
class Part:
    """A node of the part hierarchy. A leaf has no children and carries the geometry.

    Attributes:
        id: number of the node in the source file.
        name: name of the node in the source file.
        parent: index into `Shape.parts`. None for the root.
        children: indices into `Shape.parts`.
        mesh: the geometry of a leaf. None for other nodes.
    """

    id: int
    name: str
    parent: int | None
    children: tuple[int, ...] = ()
    mesh: Mesh | None = None

    @property
    def is_leaf(self) -> bool:
        return not self.children


@dataclass(frozen=True, eq=False)
class Shape:
    """An object: its part hierarchy and, if it is annotated, its mobility.

    Attributes:
        id: name of the shape, such as its folder or file name.
        category: canonical name of the object category (see `canonical_category`). Empty if it is unknown.
        parts: the nodes of the hierarchy in preorder: the root first, every parent before its children.
        source: the file or folder that the shape was read from.
        layout: name of the input format (see `kinmo.io.readers`).
        up: unit vector that points up, in the frame of the file.
        mobility: the annotated bodies and joints. None for a shape without annotation.
        partnet_id: the PartNet annotation (`anno_id`) of the shape, to recognise copies. None if there is none.
        repairs: one line for each problem that the reader repaired.
        front: unit vector towards the viewer, in the frame of the file. None if it is unknown.
        metres_per_unit: length of a unit of the file, in metres.
        guesses: what the reader had to guess: a short line each for "up", "metres_per_unit" and "category".
        labels: the file that gave the part of every triangle. None if the parts are those of the source.
    """

    id: str
    category: str
    parts: tuple[Part, ...]
    source: Path
    layout: str
    up: tuple[float, float, float] = Y_UP
    mobility: Mobility | None = None
    partnet_id: str | None = None
    repairs: tuple[str, ...] = ()
    front: tuple[float, float, float] | None = Z_FRONT
    metres_per_unit: float = 1.0
    guesses: Mapping[str, str] = field(default_factory=dict)
    labels: Path | None = None

    @cached_property
    def leaves(self) -> tuple[int, ...]:
        """Indices of the leaf parts, in preorder."""
        return tuple(i for i, part in enumerate(self.parts) if part.is_leaf)

    @cached_property
    def leaves_below(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the leaves at or below each part."""
        below: list[list[int]] = [[] for _ in self.parts]
        for leaf in self.leaves:
            node: int | None = leaf
            while node is not None:
                below[node].append(leaf)
                node = self.parts[node].parent
        return tuple(map(tuple, below))

    @cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] of the axis-aligned bounding box. Unused vertices are ignored."""
        return bounds_of(self.meshes())

    @property
    def center(self) -> Vector:
        """Centre [3] of the axis-aligned bounding box: the origin of the normalised frame."""
        low, high = self.bounds
        return 0.5 * (low + high)

    @property
    def diagonal(self) -> float:
        """Diagonal of the axis-aligned bounding box: the length unit of the normalised frame."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    def rotated(self, rotation: NDArray[np.float64]) -> Shape:
        """The shape in a frame that `rotation` [3, 3] rotates the present frame to."""
        x, y, z = (rotation @ self.up).tolist()
        front = None
        if self.front is not None:
            right, high, deep = (rotation @ self.front).tolist()
            front = (right, high, deep)
        parts = (part if part.mesh is None else replace(part, mesh=part.mesh.rotated(rotation)) for part in self.parts)
        mobility = None if self.mobility is None else self.mobility.rotated(rotation)
        return replace(self, parts=tuple(parts), up=(x, y, z), front=front, mobility=mobility)

    def leaf_mesh(self, leaf: int) -> Mesh:
        """The mesh of a leaf. `leaf` is an index into `parts`."""
        mesh = self.parts[leaf].mesh
        assert mesh is not None, "readers give every leaf a mesh"
        return mesh

    def meshes(self) -> Iterator[Mesh]:
        """Meshes of the leaves, in the order of `leaves`."""
        return map(self.leaf_mesh, self.leaves)
