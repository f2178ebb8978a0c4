"""Random fragments of parts: cut panels, inner walls and small details, of which the single mesh of a real object has hundreds.

Every fragment belongs to the body of the part that it comes from, so that joints stay true.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.loose_pieces import loose_pieces
from kinmo.core.mesh_splitting import cut_mesh
from kinmo.core.oriented_box import CORNER_SIGNS
from kinmo.core.shape import Mesh, bounds_of
from kinmo.core.shape_forms import FlatPart

PIECES = (8.0, 160.0)
"""Least and largest number of fragments that a list is broken into."""
SPREAD = 1.5
"""Standard deviation of the logarithm of how often a piece is chosen: a few pieces get most of the fragments."""
CUT_SHARE, WALL_SHARE = 0.6, 0.15
"""Shares of the changes that cut a piece, and that add an inner wall; the others add details."""
MAX_SLICES = 12
"""Most slices that a cut makes of one piece."""
GAPS = (0.0003, 0.002)
"""Smallest and largest gap between two slices, in diagonals of the shape."""
WALLS = (0.85, 0.99)
"""Smallest and largest size of an inner wall, as a share of the piece around it."""
MAX_DETAILS = 40
"""Most details of one kind."""
DETAIL_SIZES = (0.001, 0.012)
"""Smallest and largest half size of a detail, in diagonals of the shape."""
BLOCK_FACES = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ],
    np.uint32,
)
"""Corners of the triangles of a block, as indices into `CORNER_SIGNS`."""


def fragmented_parts(parts: Sequence[FlatPart], rng: np.random.Generator) -> list[FlatPart]:
    """The loose pieces of the parts, broken into a random number of fragments."""
    low, high = bounds_of(part.mesh for part in parts)
    diagonal = float(np.linalg.norm(high - low))
    pieces = [replace(part, mesh=piece) for part in parts for piece in loose_pieces(part.mesh)]
    appeal = [float(np.exp(SPREAD * rng.standard_normal())) * _size(piece.mesh) for piece in pieces]
    count = int(np.exp(rng.uniform(*np.log(PIECES))))
    for _ in range(count):  # each change adds a fragment, unless a piece is too small
        missing = count - len(pieces)
        if missing <= 0:
            break
        place = int(rng.choice(len(pieces), p=np.array(appeal) / sum(appeal)))
        piece, way = pieces[place], rng.random()
        if way < CUT_SHARE:
            kept, *added = _slices(piece.mesh, rng, min(missing + 1, MAX_SLICES), diagonal)
            pieces[place] = replace(piece, mesh=kept)
        elif way < CUT_SHARE + WALL_SHARE:
            added = [_inner_wall(piece.mesh, rng)]
        else:
            added = _details(piece.mesh, rng, min(missing, MAX_DETAILS), diagonal)
        pieces += [replace(piece, mesh=mesh) for mesh in added]
        appeal += [appeal[place] * _size(mesh) / _size(piece.mesh) for mesh in added]
        appeal[place] *= _size(pieces[place].mesh) / _size(piece.mesh)
    return pieces


def block(center: NDArray[np.float64], half: NDArray[np.float64]) -> Mesh:
    """A block along the axes of the file, from its centre [3] and its half sizes [3]."""
    return Mesh(center + CORNER_SIGNS * half, BLOCK_FACES)


def random_face(mesh: Mesh, rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """The corners [3, 3] of a random face, by area, and its normal [3]. None if no face has an area."""
    areas = mesh.face_areas
    if not areas.sum() > 0.0:
        return None
    corners = mesh.triangles[rng.choice(len(areas), p=areas / areas.sum())]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    return corners, normal / np.linalg.norm(normal)


def _size(mesh: Mesh) -> float:
    """Root of the surface area, never 0."""
    return max(float(np.sqrt(mesh.face_areas.sum())), 1e-12)


def _slices(mesh: Mesh, rng: np.random.Generator, most: int, diagonal: float) -> list[Mesh]:
    """The mesh cut by one to many parallel planes, with gaps; the mesh itself if it is too small."""
    low, high = bounds_of([mesh])
    extent = high - low
    axis = int(rng.choice(3, p=extent / extent.sum())) if extent.sum() > 0.0 else 0
    gap = float(rng.uniform(*GAPS)) * diagonal
    most = min(most, int(extent[axis] / (4.0 * gap)))
    if most < 2:
        return [mesh]
    number = 2 if rng.random() < 0.5 else int(rng.integers(2, most + 1))
    cuts = [rng.uniform(0.15, 0.85)] if number == 2 else np.arange(1, number) / number
    across, slices, rest = np.eye(3)[axis], [], mesh.bare
    for level in low[axis] + np.asarray(cuts) * extent[axis]:
        slices.append(cut_mesh(rest, -across, -(level - 0.5 * gap)))
        rest = cut_mesh(rest, across, level + 0.5 * gap)
    slices = [piece for piece in (*slices, rest) if len(piece.faces)]
    return slices or [mesh]


def _inner_wall(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """A smaller copy of the mesh inside it."""
    low, high = bounds_of([mesh])
    middle = 0.5 * (low + high)
    return Mesh(middle + float(rng.uniform(*WALLS)) * (mesh.vertices - middle), mesh.faces).flipped


def _details(mesh: Mesh, rng: np.random.Generator, most: int, diagonal: float) -> list[Mesh]:
    """Alike small blocks on the mesh: in a row on one face, or anywhere."""
    number = int(np.exp(rng.uniform(0.0, np.log(most + 1.0))))
    half = float(np.exp(rng.uniform(*np.log(DETAIL_SIZES)))) * diagonal * rng.uniform(0.2, 1.0, 3)
    start = random_face(mesh, rng)
    if start is None:
        return []
    if rng.random() < 0.5:
        first, last = rng.dirichlet([1.0, 1.0, 1.0], 2) @ start[0]
        return [block(first + share * (last - first), half) for share in np.linspace(0.0, 1.0, number)]
    faces = (random_face(mesh, rng) for _ in range(number))
    return [block(rng.dirichlet([1.0, 1.0, 1.0]) @ found[0], half) for found in faces if found is not None]
