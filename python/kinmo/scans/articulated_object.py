"""Objects as a depth camera sees them move: one mesh a rigid part, the parts in an order that is the same for all shapes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo.config import ScansConfig
from kinmo.core.errors import InputError
from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import Link, links_of
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.vector import Vector
from kinmo.scans.canonical_pose import canonical, likely_canonical
from kinmo.scans.object_variants import SIDEWAYS, changed
from kinmo.scans.part_order import canonical_order

F64 = NDArray[np.float64]

FACING = np.cos(np.radians(6.0))
"""From this cosine on a surface faces an axis."""

JOINT = rf"(?P<kind>{'|'.join(JointKind)}) on (?P<parent>\d+)"
"""What a joint of a structure looks like in tables."""


@dataclass(frozen=True)
class Structure:
    """How the parts of an object hang together.

    Part 0 is the base; `kinds[i]` is the kind of joint of part i + 1 and `parents[i]` the part that it moves against.
    """

    kinds: tuple[JointKind, ...]
    parents: tuple[int, ...]

    @classmethod
    def of(cls, joints: Sequence[str]) -> Structure:
        """Of joints as tables have them, such as `R on 0`, part by part. Raises ValueError for any other text."""
        kinds, parents = [], []
        for part, text in enumerate(joints, start=1):
            found = re.fullmatch(JOINT, text)
            if found is None or int(found["parent"]) >= part:
                raise ValueError(f"expected {', '.join(JointKind)} on a part before part {part}, such as R on 0, got {text!r}")
            kinds.append(JointKind(found["kind"]))
            parents.append(int(found["parent"]))
        return cls(tuple(kinds), tuple(parents))

    @property
    def part_count(self) -> int:
        return len(self.kinds) + 1

    def __str__(self) -> str:
        joints = (f"{kind.value} on {parent}" for kind, parent in zip(self.kinds, self.parents, strict=True))
        return f"{self.part_count} parts ({', '.join(joints)})"

    @property
    def in_words(self) -> str:
        """For messages: `2 parts (revolute on part 0)`, which tables put shortly."""
        joints = (f"{kind.name.lower()} on part {parent}" for kind, parent in zip(self.kinds, self.parents, strict=True))
        return f"{self.part_count} parts ({', '.join(joints)})"


@dataclass(frozen=True, eq=False)
class Extents:
    """Axis-aligned boxes of N things in the normalised frame: middles `centers` and `sizes`, both [..., N, 3]."""

    centers: F64
    sizes: F64

    @classmethod
    def stack(cls, extents: Sequence[Extents]) -> Extents:
        """Those of many objects of equally many parts, [len(extents), N]."""
        return cls(np.stack([each.centers for each in extents]), np.stack([each.sizes for each in extents]))

    @cached_property
    def diagonals(self) -> F64:
        """[..., N]."""
        return np.asarray(np.linalg.norm(self.sizes, axis=-1))


@dataclass(frozen=True, eq=False)
class ArticulatedObject:
    """An object whose box has its middle at the origin and the diagonal 1, ready to be scanned: its *normalised frame*.

    The bodies of `mobility` are its K parts, part 0 the base without a joint, every other one with a joint and after the part
    it moves against; `meshes` are theirs, in the object's canonical state. `up` [3] is a unit vector.
    """

    id: str
    category: str
    up: Vector
    mobility: Mobility
    meshes: tuple[Mesh, ...]

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """Those of parts 1 and up."""
        return tuple(body.joint for _, body in self.mobility.movable() if body.joint is not None)

    @cached_property
    def structure(self) -> Structure:
        parents = (body.parent for _, body in self.mobility.movable())
        return Structure(tuple(joint.kind for joint in self.joints), tuple(parent or 0 for parent in parents))

    @cached_property
    def part_extents(self) -> Extents:
        """Of the K parts, in the canonical state."""
        return _extents(mesh.corners for mesh in self.meshes)

    @cached_property
    def facing(self) -> F64:
        """The share [K] of every part's surface that faces an axis of the frame, in the canonical state."""
        return np.array([_share_facing_axes(mesh) for mesh in self.meshes])


def articulated_object(
    shape: Shape,
    mobility: Mobility | None = None,
    *,
    smallest: float = ScansConfig.smallest_part,
    closes: bool = True,
    guessed_within: float | None = None,
    change: F64 | None = None,
) -> ArticulatedObject:
    """The parts of `shape` that move by `mobility` (in its frame; its own by default), in canonical order.

    The object is in its `canonical` state, closed if it `closes`, else (as in the paper's release) as in the file; where limits
    are guesses, in the one that is likely to be it, hinges opening `guessed_within` radians from there at most. If there is a
    `change` [3, 3], it is then what `variants.changed` makes of that.

    What is fastened together is one part, and a part smaller than `smallest` is fastened to what it moves against. Junk, which
    does not belong to the object, is left out. The order is that of `part_order`.

    Raises InputError where nothing moves, or nothing that the rest could move against is there.
    """
    mobility = shape.mobility if mobility is None else mobility
    if mobility is None:
        raise InputError(shape.source, "no joints are known of it")
    meshes = {leaf: mesh for leaf, mesh in zip(shape.leaves, shape.meshes(), strict=True) if leaf not in mobility.junk}
    if not meshes:
        raise InputError(shape.source, "all of it is marked as junk")
    frame = Normalisation.about(meshes.values())
    mobility = frame.mobility(_without_junk(mobility))
    up = np.asarray(shape.up, np.float64)
    meshes = {leaf: frame.mesh(mesh) for leaf, mesh in meshes.items()}
    links = _without_small(links_of(mobility), meshes, smallest)
    if len(links) == 1:
        raise InputError(shape.source, "no part of it moves that is large enough to be seen")
    joined = tuple(join(*(meshes[leaf] for leaf in link.leaves)) for link in links)
    parts = Mobility(tuple(Body(i, link.name, link.leaves, link.parent, link.joint) for i, link in enumerate(links)))
    to_z_up = z_up_rotation(up)
    is_mirrored = change is not None and bool(np.linalg.det(change) < 0.0)
    in_the_end = SIDEWAYS @ to_z_up if is_mirrored else to_z_up  # where equal parts are told apart by how they will lie
    if closes and guessed_within is not None:
        parts, joined = likely_canonical(parts, joined, smallest, in_the_end, guessed_within)
    else:
        parts, joined = canonical(parts, joined, smallest, in_the_end, closes)
    if not parts.bodies[0].leaves:
        raise InputError(shape.source, "nothing stands still that its parts could move against")
    if change is not None:
        parts, joined = changed(parts, joined, change)
    if closes or change is not None:
        frame = Normalisation.about(joined)
        parts, joined = frame.mobility(parts), tuple(map(frame.mesh, joined))
    order = canonical_order(parts.bodies, _extents(mesh.vertices for mesh in joined).centers @ to_z_up.T)
    place = {index: position for position, index in enumerate(order)}
    bodies = (parts.bodies[index] for index in order)
    ordered = (replace(b, id=place[b.id], parent=None if b.parent is None else place[b.parent]) for b in bodies)
    return ArticulatedObject(shape.id, shape.category, up, Mobility(tuple(ordered)), tuple(joined[index] for index in order))


def still_object(shape: Shape) -> ArticulatedObject:
    """All of `shape` as one part that nothing moves, whatever is known of its joints."""
    frame = Normalisation.of(shape)
    base = Body(0, "base", tuple(shape.leaves), None, None)
    mesh = join(*(frame.mesh(mesh) for mesh in shape.meshes()))
    return ArticulatedObject(shape.id, shape.category, np.asarray(shape.up, np.float64), Mobility((base,)), (mesh,))


def _without_junk(mobility: Mobility) -> Mobility:
    bodies = (
        replace(body, leaves=tuple(leaf for leaf in body.leaves if leaf not in mobility.junk)) for body in mobility.bodies
    )
    return Mobility(tuple(bodies))


def _without_small(links: Sequence[Link], meshes: dict[int, Mesh], smallest: float) -> list[Link]:
    """The links, those that are too small joined to their parents; a link still stands after its parent."""
    keeper: list[int] = []
    for index, link in enumerate(links):
        is_small = link.parent is not None and (
            not link.leaves
            or _extents([np.concatenate([meshes[leaf].vertices for leaf in link.leaves])]).diagonals[0] < smallest
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


def _share_facing_axes(mesh: Mesh) -> float:
    places = np.ascontiguousarray(mesh.vertices.T)  # NumPy is faster along rows, and than its own cross product
    first, second, third = (np.take(places, corner, axis=1) for corner in mesh.faces.T)
    (ax, ay, az), (bx, by, bz) = second - first, third - first
    normals = np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    areas = np.linalg.norm(normals, axis=0)
    faces = np.abs(normals).max(axis=0) >= FACING * areas
    return float(areas[faces].sum() / max(areas.sum(), np.finfo(float).tiny))
