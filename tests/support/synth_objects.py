"""Objects of a family in their rest pose, and measures that tests of several families use."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.families import family_builder
from kinmo.synth.synth_object import Link, SynthObject

F64 = NDArray[np.float64]


def build_object(name: str, seed: int) -> SynthObject:
    """The object of a family for a seed, in its rest pose, with a diagonal of 1."""
    shape = family_builder(name)(Draw(np.random.default_rng(seed)))
    shape.apply_rest_pose()
    shape.normalise(1.0)
    return shape


def moving_links(shape: SynthObject) -> Iterator[Link]:
    """Links with a joint."""
    return (link for link in shape.links if link.motion is not None)


def links_with_leaf(shape: SynthObject, *names: str) -> Iterator[Link]:
    """Links with a joint and a leaf of one of `names`."""
    return (link for link in moving_links(shape) if any(leaf.name in names for leaf in link.leaves()))


def moving_and_other_pieces(shape: SynthObject, link: Link) -> tuple[list[Mesh], list[Mesh]]:
    """The pieces that move with a link, and all others."""
    moving = {id(leaf) for below in shape.subtree(link) for leaf in below.leaves()}
    own = [piece for leaf in shape.root.leaves() if id(leaf) in moving for piece in leaf.pieces]
    return own, [piece for leaf in shape.root.leaves() if id(leaf) not in moving for piece in leaf.pieces]


def link_pieces(link: Link) -> list[Mesh]:
    """The pieces of a link, without those of its child links."""
    return [piece for leaf in link.leaves() for piece in leaf.pieces]


def link_vertices(link: Link) -> F64:
    """Vertices [N, 3] of all pieces of a link."""
    return np.concatenate([piece.vertices for piece in link_pieces(link)])


def surface_points(pieces: list[Mesh], count: int, seed: int = 0) -> F64:
    """Points [N, 3] uniform on the surfaces."""
    rng = np.random.default_rng(seed)
    corners = np.concatenate([piece.vertices[piece.faces] for piece in pieces])
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = rng.choice(len(corners), count, p=areas / areas.sum())
    return np.einsum("nk,nki->ni", rng.dirichlet(np.ones(3), count), corners[chosen])


def share_inside(points: F64, pieces: list[Mesh]) -> float:
    """Share of points that are inside any piece, by winding numbers."""
    inside = np.zeros(len(points), bool)
    for piece in pieces:
        low, high = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
        near = np.all((points > low) & (points < high), axis=1) & ~inside
        if near.any():
            inside[near] = np.abs(_winding(points[near], piece.vertices[piece.faces])) > 0.5
    return float(inside.mean())


def sinking_share(shape: SynthObject, link: Link, poses: int = 5) -> float:
    """Largest share of a moving part's surface that enters the other pieces, minus the share inside them in the rest pose."""
    assert link.motion is not None
    own, rest = moving_and_other_pieces(shape, link)
    points = surface_points(own, 80)
    inside = share_inside(points, rest)
    span = (-180.0, 180.0) if link.motion.no_limit else (link.motion.a, link.motion.b)
    moved = (link.motion.at(value) for value in np.linspace(*span, poses))
    return max(share_inside(points @ pose[:3, :3].T + pose[:3, 3], rest) for pose in moved) - inside


def axis_distances(points: F64, link: Link) -> F64:
    """Distances [N] of points from a link's axis."""
    assert link.motion is not None
    direction = link.motion.direction / np.linalg.norm(link.motion.direction)
    offsets = points - link.motion.origin
    return np.linalg.norm(offsets - np.outer(offsets @ direction, direction), axis=1)


def bounds_of(pieces: list[Mesh]) -> tuple[F64, F64]:
    """Smallest and largest corner [3]."""
    corners = np.concatenate([piece.vertices for piece in pieces])
    return corners.min(axis=0), corners.max(axis=0)


def _winding(points: F64, triangles: F64) -> F64:
    """Winding number [N] of a closed surface around points, as the sum of its triangles' solid angles."""
    a, b, c = (triangles[None, :, corner] - points[:, None] for corner in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    volume = np.sum(a * np.cross(b, c), axis=-1)
    spread = la * lb * lc + np.sum(a * b, -1) * lc + np.sum(b * c, -1) * la + np.sum(c * a, -1) * lb
    return np.asarray(np.arctan2(volume, spread).sum(axis=1) / (2 * np.pi))
