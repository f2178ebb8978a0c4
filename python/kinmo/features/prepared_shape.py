"""A shape as training reads it: points, boxes, distances and labels, computed once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.box import Box
from kinmo.core.edge_labels import EdgeLabels
from kinmo.core.errors import InputError
from kinmo.core.joint import MotionType
from kinmo.core.mobility import Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Shape

SAME = 1e-9
"""In diagonals: other machines round otherwise."""

F32 = NDArray[np.float32]
I64 = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Boxes:
    """Oriented boxes of N parts: `centers` [N, 3], `axes` [N, 3, 3] (unit rows), `half_extents` [N, 3], float64."""

    centers: NDArray[np.float64]
    axes: NDArray[np.float64]
    half_extents: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.centers)

    def __getitem__(self, index: int) -> Box:
        return Box(self.centers[index], self.axes[index], self.half_extents[index])


def units_of(parts: Sequence[tuple[int, ...]], bodies: Sequence[tuple[int, ...]]) -> tuple[tuple[int, ...], ...]:
    """The distinct sets of leaves that are a part below the root (all `parts` but the first) or a body, parts first."""
    return tuple(dict.fromkeys((*parts[1:], *bodies)))


def part_sizes(parts: Sequence[tuple[int, ...]], boxes: Boxes) -> NDArray[np.float64]:
    """Half extents [P, 3] of the distinct parts below the root (`units_of(parts, ())`); `boxes` are those of all `parts`."""
    place = {part: index for index, part in enumerate(parts)}
    return boxes.half_extents[[place[part] for part in units_of(parts, ())]]


@dataclass(frozen=True, eq=False)
class PreparedShape:
    """Everything the stages after `prepare` need of a shape, in the *normalised frame*.

    The normalised frame has the file's axes, its origin at `center` (the middle of the axis-aligned box, in the file's lengths)
    and `diagonal` (of that box) as its unit of length: file = normalised * diagonal + center. N parts in preorder, L leaves, E
    edges (all ordered sibling pairs).
    """

    id: str
    category: str
    layout: str
    source: str
    partnet_id: str | None
    geometry_hash: str
    up: NDArray[np.float64]
    center: NDArray[np.float64]
    diagonal: float
    part_ids: tuple[int, ...]
    part_names: tuple[str, ...]
    parents: tuple[int, ...]
    """Index of every part's parent, -1 for the root."""
    leaves: tuple[int, ...]
    leaf_points: F32
    """[L, n, 3], area-uniform samples of the leaves' surfaces."""
    leaf_normals: F32
    """[L, n, 3], unit normals at the samples."""
    leaf_areas: NDArray[np.float64]
    """[L], in squared diagonals."""
    minimum_boxes: Boxes
    """Minimum-volume boxes of all N parts."""
    symmetric_boxes: Boxes
    """Symmetry-aligned boxes of all N parts (Fish 2014)."""
    aligned_boxes: Boxes
    """Boxes of all N parts along the axes of the file's frame."""
    edges: I64
    """[E, 2] (moving, reference) indices of parts."""
    edge_distances: NDArray[np.float64]
    """[E], exact distance between the two parts."""
    mobility: Mobility | None = None
    """The annotation, in the normalised frame; None for a shape without one."""
    body_boxes: Boxes | None = None
    """Symmetry-aligned boxes of the bodies of `mobility`."""
    body_types: Mapping[int, MotionType] = field(default_factory=dict)
    """Motion type of every movable body."""
    edge_labels: EdgeLabels | None = None
    evidence: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    """Arrays of the `kinmo` method by name (`kinmo.features.candidate_features.Evidence`), for the units of `units_of`."""

    @property
    def annotation(self) -> tuple[Mobility, Boxes]:
        """Mobility, and boxes of its bodies, of a shape that must be annotated.

        Raises:
            InputError: the shape is not annotated.
        """
        if self.mobility is None or self.body_boxes is None:
            raise InputError(self.source, f"expected shape {self.id} to be annotated")
        return self.mobility, self.body_boxes

    @cached_property
    def body_leaves(self) -> tuple[tuple[int, ...], ...]:
        """For every body of the annotation, the positions *in `leaves`* of its leaves, ascending."""
        if self.mobility is None:
            return ()
        position = {leaf: place for place, leaf in enumerate(self.leaves)}
        return tuple(tuple(sorted(position[leaf] for leaf in body.leaves)) for body in self.mobility.bodies)

    @cached_property
    def leaves_below(self) -> tuple[tuple[int, ...], ...]:
        """For every part, the positions *in `leaves`* of the leaves at or below it."""
        below: list[list[int]] = [[] for _ in self.parents]
        for position, leaf in enumerate(self.leaves):
            node = leaf
            while node >= 0:
                below[node].append(position)
                node = self.parents[node]
        return tuple(map(tuple, below))


def check_unchanged(shape: Shape, prepared: PreparedShape) -> None:
    """Raises InputError where `shape`, read from its files, has other parts than were prepared, or another size or place."""
    has_parts = tuple(part.id for part in shape.parts) == prepared.part_ids
    place, wanted = ([*one.center, one.diagonal] for one in (shape, prepared))
    if not has_parts or not np.allclose(place, wanted, rtol=0.0, atol=SAME * prepared.diagonal):
        raise InputError(prepared.source, "has changed since it was prepared: run kinmo prepare again")


def leaf_meshes(shape: Shape, prepared: PreparedShape) -> _core.Meshes:
    """Meshes of the leaves of `shape`, in the normalised frame of `prepared`.

    Raises:
        InputError: `shape` is not the one that was prepared.
    """
    check_unchanged(shape, prepared)
    frame = Normalisation(prepared.center, prepared.diagonal)
    meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    return _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
