"""A 3D object as a hierarchy of parts, in the frame and the lengths of its source file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.mobility import Mobility
from kinmo.core.vector import Vector

Y_UP: tuple[float, float, float] = (0.0, 1.0, 0.0)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles. `vertices` [V, 3] float64 in the file's lengths, `faces` [F, 3] uint32."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]

    def turned(self, rotation: NDArray[np.float64]) -> Mesh:
        """The same triangles in a frame to which `rotation` [3, 3] takes this one's."""
        return Mesh(self.vertices @ rotation.T, self.faces)

    @property
    def corners(self) -> NDArray[np.float64]:
        """The vertices [U, 3] that triangles use, each once, in their order."""
        return self.vertices[self._is_used]

    @property
    def compact(self) -> Mesh:
        """The same triangles without vertices that none of them uses."""
        used = self._is_used
        return Mesh(self.vertices[used], (np.cumsum(used) - 1)[self.faces].astype(np.uint32))

    @property
    def _is_used(self) -> NDArray[np.bool_]:
        used = np.zeros(len(self.vertices), bool)
        used[self.faces] = True
        return used


def join(*meshes: Mesh) -> Mesh:
    """One mesh with all vertices and faces of some, or of none."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)]).astype(np.uint32)
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts[:-1], strict=True)]
    nothing = np.zeros((0, 3))
    return Mesh(
        np.concatenate([nothing, *(mesh.vertices for mesh in meshes)]), np.concatenate([nothing.astype(np.uint32), *faces])
    )


def bounds_of(meshes: Iterable[Mesh]) -> tuple[Vector, Vector]:
    """Smallest and largest corner [3] of the axis-aligned box of all vertices that a face uses; there must be some."""
    used = [mesh.corners for mesh in meshes]
    return np.min([v.min(axis=0) for v in used], axis=0), np.max([v.max(axis=0) for v in used], axis=0)


@dataclass(frozen=True, eq=False)
class Part:
    """A node of the hierarchy. A part without children is a leaf and carries the geometry.

    `parent` and `children` are indices into `Shape.parts`; `id` is the number that the source file gives the node.
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
    """An object: its part hierarchy and, where it is annotated, its mobility.

    `parts` is in preorder: the root is `parts[0]` and a parent stands before its children. `up` is a unit vector in the file's
    frame. `mobility` is None for a shape that is not annotated. `partnet_id` is the PartNet annotation the shape comes from
    (`anno_id`), by which copies of one shape are recognised. `repairs` says what the reader had to mend.
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

    @cached_property
    def leaves(self) -> tuple[int, ...]:
        """Indices of the leaf parts, in preorder."""
        return tuple(i for i, part in enumerate(self.parts) if part.is_leaf)

    @cached_property
    def leaves_below(self) -> tuple[tuple[int, ...], ...]:
        """For every part, the indices of the leaves at or below it."""
        below: list[list[int]] = [[] for _ in self.parts]
        for leaf in self.leaves:
            node: int | None = leaf
            while node is not None:
                below[node].append(leaf)
                node = self.parts[node].parent
        return tuple(map(tuple, below))

    @cached_property
    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest corner [3] of the axis-aligned box of all vertices that a face uses."""
        return bounds_of(self.meshes())

    @property
    def center(self) -> Vector:
        """Centre [3] of the axis-aligned box: the origin of the normalised frame."""
        low, high = self.bounds
        return 0.5 * (low + high)

    @property
    def diagonal(self) -> float:
        """Diagonal of the axis-aligned box: the unit of length of the normalised frame."""
        low, high = self.bounds
        return float(np.linalg.norm(high - low))

    def turned(self, rotation: NDArray[np.float64]) -> Shape:
        """The same shape in a frame to which `rotation` [3, 3] takes its own."""
        x, y, z = (rotation @ self.up).tolist()
        parts = (part if part.mesh is None else replace(part, mesh=part.mesh.turned(rotation)) for part in self.parts)
        mobility = None if self.mobility is None else self.mobility.turned(rotation)
        return replace(self, parts=tuple(parts), up=(x, y, z), mobility=mobility)

    def meshes(self) -> Iterator[Mesh]:
        """Meshes of the leaves, in the order of `leaves`."""
        for leaf in self.leaves:
            mesh = self.parts[leaf].mesh
            assert mesh is not None, "a leaf carries a mesh: readers make sure of it"
            yield mesh
