"""Mesh flaws of modelling tools: fine or torn triangulations, unwelded or doubled faces, inverted surfaces, flat sheets."""

from __future__ import annotations

import numpy as np

from kinmo.core.shape import Mesh, join
from kinmo.synth.draw import Draw
from kinmo.synth.primitives.transforms import inside_out
from kinmo.synth.synth_object import SynthObject

UNWELDED_SHARE = 0.2
"""Share of objects whose triangles share no vertices."""
INSIDE_OUT_SHARE = 0.04
"""Share of pieces whose faces are inverted."""
DOUBLED_SHARE = 0.03
"""Share of pieces that exist twice, once inverted."""
TORN_SHARE = 0.02
"""Share of pieces that lack some triangles."""
SHEET_SHARE = 0.02
"""Share of thin pieces that are pressed flat."""
SHEET_RATIO = 0.12
"""Largest thickness of a thin piece, over its second smallest side."""
FINE_SHARE = 0.8
"""Share of objects of which some pieces are subdivided."""
MAX_PIECE_TRIANGLES = 4000
"""Most triangles of a piece after subdivision."""


def add_mesh_quirks(obj: SynthObject, draw: Draw) -> None:
    """Give the meshes of an object flaws, in place. No surface moves."""
    unwelded, fine = draw.chance(UNWELDED_SHARE), draw.chance(FINE_SHARE)
    for leaf in obj.root.leaves():
        leaf.pieces = [_flawed(piece, draw, unwelded, fine) for piece in leaf.pieces]


def flatten_thin_panels(obj: SynthObject, draw: Draw) -> None:
    """Press some thin pieces of an object flat, in place."""
    for leaf in obj.root.leaves():
        leaf.pieces = [as_sheet(piece) if draw.chance(SHEET_SHARE) else piece for piece in leaf.pieces]


def _flawed(piece: Mesh, draw: Draw, unwelded: bool, fine: bool) -> Mesh:
    levels = draw.pick([0, 1, 2, 3, 4], [3, 4, 4, 2, 1]) if fine else 0
    for _ in range(levels):
        if 4 * len(piece.faces) <= MAX_PIECE_TRIANGLES:
            piece = subdivided(piece)
    flaw = draw.between(0, 1)
    if flaw < INSIDE_OUT_SHARE:
        piece = inside_out(piece)
    elif flaw < INSIDE_OUT_SHARE + DOUBLED_SHARE:
        piece = join(piece, inside_out(piece))
    elif flaw < INSIDE_OUT_SHARE + DOUBLED_SHARE + TORN_SHARE and len(piece.faces) > 40:
        start = draw.integer(0, len(piece.faces) - 1)
        piece = Mesh(piece.vertices, np.delete(piece.faces, np.arange(start, min(start + 4, len(piece.faces))), axis=0))
    if unwelded:
        piece = Mesh(piece.vertices[piece.faces.ravel()], np.arange(piece.faces.size, dtype=np.uint32).reshape(-1, 3))
    return piece


def as_sheet(mesh: Mesh) -> Mesh:
    """An axis-aligned thin panel, pressed flat to its middle; any other mesh unchanged."""
    extents = np.ptp(mesh.vertices, axis=0)
    thin = int(np.argmin(extents))
    if extents[thin] >= SHEET_RATIO * np.delete(extents, thin).min():
        return mesh
    vertices = mesh.vertices.copy()
    vertices[:, thin] = 0.5 * (vertices[:, thin].min() + vertices[:, thin].max())
    corners = vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return Mesh(vertices, mesh.faces[areas > 0.0])


def subdivided(mesh: Mesh) -> Mesh:
    """The mesh with every triangle cut into four, through the midpoints of its edges."""
    faces = mesh.faces.astype(np.int64)
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, index = np.unique(edges[:, 0] * len(mesh.vertices) + edges[:, 1], return_inverse=True)
    ends = np.stack(np.divmod(keys, len(mesh.vertices)), axis=1)
    middles = mesh.vertices[ends].mean(axis=1)
    ab, bc, ca = (len(mesh.vertices) + index.reshape(-1, 3)).T
    a, b, c = faces.T
    quartered = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate([mesh.vertices, middles]), quartered.astype(np.uint32))
