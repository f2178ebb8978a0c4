"""A shape as networks read it: samples, boxes, distances and labels, computed once by `kinmo prepare`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.edge_labels import EdgeLabels
from kinmo.core.errors import InputError
from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.normalisation import Normalisation
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Shape

SAME_POSITION = 1e-9
"""Largest difference, in diagonals, between equal positions; rounding differs between machines."""

F32 = NDArray[np.float32]
I64 = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Boxes:
    """N oriented boxes.

    Attributes:
        centers ([N, 3] float64): Centres.
        axes ([N, 3, 3] float64): Axes, unit rows.
        half_extents ([N, 3] float64): Half extents along the axes.
    """

    centers: NDArray[np.float64]
    axes: NDArray[np.float64]
    half_extents: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.centers)

    def __getitem__(self, index: int) -> Box:
        return Box(self.centers[index], self.axes[index], self.half_extents[index])

    def subset(self, rows: slice | Sequence[int]) -> Boxes:
        """The boxes at some rows, in that order."""
        return Boxes(self.centers[rows], self.axes[rows], self.half_extents[rows])


@dataclass(frozen=True, eq=False)
class PreparedShape:
    """All data of a shape that the stages after `kinmo prepare` need, in the *normalised frame*.

    The normalised frame has the file's axes. Its origin is `center`, the middle of the axis-aligned box in the file's lengths.
    Its unit of length is `diagonal`, the diagonal of that box: `file = normalised * diagonal + center`. The shape has N parts
    in preorder, L leaves and E edges.
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
    """[N], index of every part's parent, -1 for the root."""
    leaves: tuple[int, ...]
    """[L], indices of the parts that are leaves."""
    leaf_points: F32
    """[L, n, 3], area-uniform samples of the leaves' surfaces."""
    leaf_normals: F32
    """[L, n, 3], unit normals at the samples."""
    leaf_areas: NDArray[np.float64]
    """[L], surface areas in squared diagonals."""
    minimum_boxes: Boxes
    """Minimum-volume boxes of all N parts."""
    symmetric_boxes: Boxes
    """Symmetry-aligned boxes of all N parts (Fish et al. 2014; paper, section 3.2)."""
    aligned_boxes: Boxes
    """Boxes of all N parts along the axes of the file's frame."""
    edges: I64
    """[E, 2] (moving, reference) indices of parts: all ordered pairs of siblings."""
    edge_distances: NDArray[np.float64]
    """[E], exact distances between the two parts."""
    mobility: Mobility | None = None
    """The annotation, in the normalised frame; None for a shape without one."""
    body_boxes: Boxes | None = None
    """Symmetry-aligned boxes of the bodies of `mobility`."""
    body_types: Mapping[int, MotionType] = field(default_factory=dict)
    """Motion type of every movable body."""
    edge_labels: EdgeLabels | None = None
    """Labels of the edges, from the annotation."""
    candidate_features: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    """Arrays of `kinmo.features.candidate_features.CandidateFeatures` by name, for all parts below the root and all bodies."""
    contact_graph: Mapping[str, NDArray[np.generic]] = field(default_factory=dict)
    """Arrays of `kinmo.features.contact_graph.ContactGraph` by name."""

    @property
    def annotation(self) -> tuple[Mobility, Boxes]:
        """Mobility, and boxes of its bodies, of a shape that must be annotated.

        Raises:
            InputError: The shape is not annotated.
        """
        if self.mobility is None or self.body_boxes is None:
            raise InputError(self.source, f"expected shape {self.id} to be annotated")
        return self.mobility, self.body_boxes

    @cached_property
    def body_leaves(self) -> tuple[tuple[int, ...], ...]:
        """Positions *in `leaves`* of the leaves of every body of the annotation, ascending."""
        if self.mobility is None:
            return ()
        position = {leaf: place for place, leaf in enumerate(self.leaves)}
        return tuple(tuple(sorted(position[leaf] for leaf in body.leaves)) for body in self.mobility.bodies)

    @cached_property
    def leaves_below(self) -> tuple[tuple[int, ...], ...]:
        """Positions *in `leaves`* of the leaves at or below every part, ascending."""
        below: list[list[int]] = [[] for _ in self.parents]
        for position, leaf in enumerate(self.leaves):
            node = leaf
            while node >= 0:
                below[node].append(position)
                node = self.parents[node]
        return tuple(map(tuple, below))


def check_unchanged(shape: Shape, prepared: PreparedShape) -> None:
    """Check that a shape, read from its files, is the one that was prepared.

    Raises:
        InputError: `shape` has other parts, or another size or position.
    """
    has_parts = tuple(part.id for part in shape.parts) == prepared.part_ids
    found, expected = ([*one.center, one.diagonal] for one in (shape, prepared))
    if not has_parts or not np.allclose(found, expected, rtol=0.0, atol=SAME_POSITION * prepared.diagonal):
        raise InputError(prepared.source, "has changed since it was prepared: run kinmo prepare again")


def leaf_meshes(shape: Shape, prepared: PreparedShape) -> _core.Meshes:
    """Meshes of the leaves of `shape`, as read from its files, in the normalised frame of `prepared`.

    Raises:
        InputError: `shape` is not the one that was prepared.
    """
    check_unchanged(shape, prepared)
    frame = Normalisation(prepared.center, prepared.diagonal)
    meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    return _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])
