"""Parts that open do not enter the housing that they open."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, QhullError
from synth_objects import link_pieces

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.families import family_builder
from kinmo.synth.synth_object import Link, SynthObject

MIN_DEPTH = 0.04
"""Depth from which a point counts as inside, as a fraction of the object's diagonal."""
FAMILIES = ["box", "dishwasher", "microwave", "oven", "refrigerator", "safe", "storage_furniture", "table", "toilet", "window"]


def half_spaces(piece: Mesh) -> np.ndarray | None:
    """Outward planes [F, 4] of a convex, solid piece; None for other pieces."""
    try:
        hull = ConvexHull(piece.vertices)
    except QhullError:
        return None
    a, b, c = (piece.vertices[piece.faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    return np.asarray(hull.equations) if abs(volume - hull.volume) < 1e-3 * hull.volume else None


def depth_inside(points: np.ndarray, solids: list[np.ndarray]) -> np.ndarray:
    """Depth [N] of each point inside the solid it is deepest in; negative outside all solids."""
    depths = [np.min(-(points @ planes[:, :3].T + planes[:, 3]), axis=1) for planes in solids]
    return np.max(depths, axis=0) if depths else np.full(len(points), -np.inf)


def points_of(link: Link) -> np.ndarray:
    """Corners and centres of the triangles of a link."""
    corners = [piece.vertices[piece.faces] for piece in link_pieces(link)]
    return np.concatenate([np.concatenate([c.mean(axis=1), c.reshape(-1, 3)]) for c in corners])


def deep_share(obj: SynthObject, link: Link, value: float) -> float:
    """Share of a link's points that are deep inside its parent, at a joint value."""
    assert link.motion is not None and link.parent is not None
    matrix = link.motion.at(value)
    moved = points_of(link) @ matrix[:3, :3].T + matrix[:3, 3]
    solids = [planes for planes in map(half_spaces, link_pieces(link.parent)) if planes is not None]
    low, high = obj.bounds()
    return float(np.mean(depth_inside(moved, solids) > MIN_DEPTH * np.linalg.norm(high - low)))


@pytest.mark.parametrize("name", FAMILIES)
def test_opening_parts_clear_their_housing(name: str) -> None:
    worse, joints = 0, 0
    for seed in range(8):
        obj = family_builder(name)(Draw(np.random.default_rng(seed)))
        for link in obj.links:
            if link.motion is None or link.motion.no_limit:
                continue
            closed = deep_share(obj, link, 0.0)
            opened = max(deep_share(obj, link, share * link.motion.b) for share in (0.3, 0.6, 1.0))
            worse += opened > closed + 0.15
            joints += 1
    assert joints > 5
    assert worse <= 0.1 * joints
