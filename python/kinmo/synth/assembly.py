"""Assembly: how the pieces of an object meet and how many meshes they are, which differs between modelling tools."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from kinmo.core.shape import Mesh, join
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import SynthObject

JOINED_SHARE, LOOSE_SHARE = 0.25, 0.2
"""Shares of objects whose leaves are one mesh each, and whose pieces are split into connected surfaces."""
LOOSE_FIT_SHARE, TIGHT_FIT_SHARE = 0.2, 0.2
"""Shares of objects whose boards stop short of each other, and whose boards run into each other."""
MAX_FIT = 0.006
"""Largest distance by which a face of a board moves, as a fraction of the object's diagonal."""
_BOX_CORNERS = 8


def assemble(obj: SynthObject, draw: Draw) -> None:
    """Change how boards meet, and join or split meshes, in place. Links and joints stay as they are."""
    fit = draw.pick([0.0, -1.0, 1.0], [1 - LOOSE_FIT_SHARE - TIGHT_FIT_SHARE, LOOSE_FIT_SHARE, TIGHT_FIT_SHARE])
    low, high = obj.bounds()
    largest = MAX_FIT * float(np.linalg.norm(high - low)) * draw.between(0.1, 1.0)
    form = draw.pick(["as built", "joined", "loose"], [1 - JOINED_SHARE - LOOSE_SHARE, JOINED_SHARE, LOOSE_SHARE])
    for leaf in obj.root.leaves():
        if fit:
            leaf.pieces = [_refitted(piece, fit * largest, draw) for piece in leaf.pieces]
        if form == "joined":
            leaf.pieces = [join(*leaf.pieces)]
        elif form == "loose":
            leaf.pieces = [part for piece in leaf.pieces for part in connected_pieces(piece)]


def connected_pieces(mesh: Mesh) -> list[Mesh]:
    """The connected surfaces of a mesh, by shared vertices."""
    count = len(mesh.vertices)
    ends = mesh.faces[:, [0, 1, 1, 2]].reshape(-1, 2).astype(np.int64)
    links = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    labels = connected_components(links, directed=False)[1][mesh.faces[:, 0]]
    return [Mesh(mesh.vertices, mesh.faces[labels == label]).compact for label in np.unique(labels)]


def _refitted(piece: Mesh, growth: float, draw: Draw) -> Mesh:
    """A board whose six faces move outwards by up to `growth` (inwards if negative); other pieces as they are."""
    if len(piece.vertices) != _BOX_CORNERS:
        return piece
    low, high = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
    at_low, at_high = np.isclose(piece.vertices, low), np.isclose(piece.vertices, high)
    if not np.all(at_low ^ at_high):
        return piece
    amounts = np.array([[draw.between(0.0, growth) for _ in range(3)] for _ in range(2)])
    amounts = np.maximum(amounts, -0.2 * (high - low))  # a thin board keeps most of its thickness
    return Mesh(piece.vertices - at_low * amounts[0] + at_high * amounts[1], piece.faces)
