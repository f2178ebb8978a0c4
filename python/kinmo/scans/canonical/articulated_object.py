"""Articulated objects ready to be scanned: one mesh per rigid part, in canonical pose and canonical part order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.errors import InputError
from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint
from kinmo.core.links import Link, links_of
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.vector import Vector
from kinmo.scans.canonical.canonical_pose import to_canonical_pose, to_estimated_canonical_pose
from kinmo.scans.canonical.closed_pose import area_normals
from kinmo.scans.canonical.object_variants import MIRROR, apply_variant
from kinmo.scans.canonical.part_order import canonical_order, reordered
from kinmo.scans.object_structure import Extents, Structure

F64 = NDArray[np.float64]

MIN_ALIGNED_COSINE = np.cos(np.radians(6.0))
"""Cosine between a normal and an axis from which on a surface is axis-aligned."""


@dataclass(frozen=True, eq=False)
class ArticulatedObject:
    """An object in its normalised frame: its box has the middle at the origin and the diagonal 1.

    Attributes:
        up: Unit vector [3].
        mobility: K bodies, one per part. Part 0 is the base; each other part has a joint and follows its parent.
        meshes: K meshes in the canonical pose.
    """

    id: str
    category: str
    up: Vector
    mobility: Mobility
    meshes: tuple[Mesh, ...]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Joints of parts 1 and up."""
        return tuple(body.joint for _, body in self.mobility.movable() if body.joint is not None)

    @cached_property
    def structure(self) -> Structure:
        """Joint kinds and parents of the parts."""
        parents = (body.parent for _, body in self.mobility.movable())
        return Structure(tuple(joint.kind for joint in self.joints), tuple(parent or 0 for parent in parents))

    @cached_property
    def part_extents(self) -> Extents:
        """Axis-aligned boxes of the K parts in the canonical pose."""
        return _extents(mesh.corners for mesh in self.meshes)

    @cached_property
    def axis_aligned_shares(self) -> F64:
        """Share [K] of each part's surface that is axis-aligned in the canonical pose."""
        return np.array([_axis_aligned_share(mesh) for mesh in self.meshes])


def articulated_object(
    shape: Shape,
    *,
    min_part_size: float = ScansConfig.smallest_part,
    closes: bool = True,
    max_guessed_opening: float | None = None,
    variant_matrix: F64 | None = None,
) -> ArticulatedObject:
    """Articulated object of a shape with joints, in its canonical pose and normalised frame.

    Bodies that are fixed to each other are one part. A part smaller than `min_part_size` is fixed to its parent. Junk is left
    out. Parts are in the order of `part_order`.

    Args:
        shape: The shape.
        min_part_size: Smallest diagonal of a part, in diagonals of the object.
        closes: True for the closed pose, False for the pose of the file, as in the paper's release.
        max_guessed_opening: For joints with guessed limits: the largest width of a hinge's range, rad. The closed pose is then
            estimated. None: limits are true.
        variant_matrix: Matrix [3, 3] of `sample_variant_matrix`, for a mirrored or stretched variant of the object.

    Raises:
        InputError: If the joints are unknown, all leaves are junk, no part moves, or there is no base to move against.
    """
    mobility = shape.mobility
    if mobility is None:
        raise InputError(shape.source, "no joints are known of it")
    meshes = {leaf: mesh for leaf, mesh in zip(shape.leaves, shape.meshes(), strict=True) if leaf not in mobility.junk}
    if not meshes:
        raise InputError(shape.source, "all of it is marked as junk")
    frame = Normalisation.about(meshes.values())
    kept = [tuple(leaf for leaf in body.leaves if leaf not in mobility.junk) for body in mobility.bodies]
    bodies = (replace(body, leaves=leaves) for body, leaves in zip(mobility.bodies, kept, strict=True))
    mobility = frame.mobility(Mobility(tuple(bodies)))
    up = np.asarray(shape.up, np.float64)
    meshes = {leaf: frame.mesh(mesh) for leaf, mesh in meshes.items()}
    links = _without_small(links_of(mobility), meshes, min_part_size)
    if len(links) == 1:
        raise InputError(shape.source, "no part of it moves that is large enough to be seen")
    joined = tuple(join(*(meshes[leaf] for leaf in link.leaves)) for link in links)
    parts = Mobility(tuple(Body(i, link.name, link.leaves, link.parent, link.joint) for i, link in enumerate(links)))
    to_z_up = z_up_rotation(up)
    is_mirrored = variant_matrix is not None and bool(np.linalg.det(variant_matrix) < 0.0)
    # Equal parts are told apart by their position in the final, possibly mirrored object.
    final_to_z_up = MIRROR @ to_z_up if is_mirrored else to_z_up
    if closes and max_guessed_opening is not None:
        parts, joined = to_estimated_canonical_pose(parts, joined, min_part_size, final_to_z_up, max_guessed_opening)
    else:
        parts, joined = to_canonical_pose(parts, joined, min_part_size, final_to_z_up, closes)
    if not parts.bodies[0].leaves:
        raise InputError(shape.source, "nothing stands still that its parts could move against")
    if variant_matrix is not None:
        parts, joined = apply_variant(parts, joined, variant_matrix)
    if closes or variant_matrix is not None:
        frame = Normalisation.about(joined)
        parts, joined = frame.mobility(parts), tuple(map(frame.mesh, joined))
    order = canonical_order(parts.bodies, _extents(mesh.vertices for mesh in joined).centers @ to_z_up.T)
    ordered = Mobility(reordered(parts.bodies, order))
    return ArticulatedObject(shape.id, shape.category, up, ordered, tuple(joined[index] for index in order))


def single_part_object(shape: Shape) -> ArticulatedObject:
    """The whole shape as one part without joints, whatever is known of its joints."""
    frame = Normalisation.of(shape)
    base = Body(0, "base", tuple(shape.leaves), None, None)
    mesh = join(*(frame.mesh(mesh) for mesh in shape.meshes()))
    return ArticulatedObject(shape.id, shape.category, np.asarray(shape.up, np.float64), Mobility((base,)), (mesh,))


def _without_small(links: Sequence[Link], meshes: dict[int, Mesh], min_size: float) -> list[Link]:
    """The links, parents first, with each too small one joined to its parent."""
    keeper: list[int] = []
    for index, link in enumerate(links):
        is_small = link.parent is not None and (
            not link.leaves
            or _extents([np.concatenate([meshes[leaf].vertices for leaf in link.leaves])]).diagonals[0] < min_size
        )
        keeper.append(keeper[link.parent] if is_small and link.parent is not None else index)
    kept = sorted(set(keeper))
    place = {index: position for position, index in enumerate(kept)}
    result = []
    for index in kept:
        leaves = sorted(leaf for other, link in enumerate(links) if keeper[other] == index for leaf in link.leaves)
        parent = links[index].parent
        result.append(replace(links[index], leaves=tuple(leaves), parent=None if parent is None else place[keeper[parent]]))
    return result


def _extents(clouds: Iterable[F64]) -> Extents:
    corners = np.array([(cloud.min(axis=0), cloud.max(axis=0)) for cloud in clouds])
    return Extents(corners.mean(axis=1), corners[:, 1] - corners[:, 0])


def _axis_aligned_share(mesh: Mesh) -> float:
    """Share of the surface that faces an axis of the frame."""
    normals = area_normals(mesh)
    areas = np.linalg.norm(normals, axis=1)
    is_aligned = np.abs(normals).max(axis=1) >= MIN_ALIGNED_COSINE * areas
    return float(areas[is_aligned].sum() / max(areas.sum(), np.finfo(float).tiny))
