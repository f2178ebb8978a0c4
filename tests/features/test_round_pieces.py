"""Round pieces of a shape, which parts may turn about."""

from __future__ import annotations

import numpy as np
import trimesh
from cabinet_geometry import UP, geometry_of

from kinmo.core.joint import JointKind
from kinmo.features.candidate_features import compute_candidate_features
from kinmo.features.group_geometry import group_geometries
from kinmo.features.round_pieces import MAX_PIECES, RoundPieces
from kinmo.features.shape_geometry import ShapeGeometry


def scissors(screw_at: tuple[float, float]) -> ShapeGeometry:
    """Two flat blades on each other, a screw through both, and a separate post."""
    x, z = screw_at
    upright = trimesh.transformations.rotation_matrix(np.pi / 2, [1.0, 0.0, 0.0])
    solids = [
        trimesh.creation.box((0.8, 0.02, 0.08)).apply_translation([0.0, 0.01, 0.0]),
        trimesh.creation.box((0.8, 0.02, 0.08)).apply_translation([0.02, -0.01, 0.01]),
        trimesh.creation.cylinder(0.012, 0.06, sections=24, transform=upright).apply_translation([x, 0.0, z]),
        trimesh.creation.cylinder(0.02, 0.3, sections=24, transform=upright).apply_translation([0.0, 0.0, 0.3]),
    ]
    return geometry_of(solids)


def test_blades_may_turn_about_the_screw_that_they_touch() -> None:
    """Closed blades touch along their length, and the screw is at no edge of either: only the round piece is on its axis."""
    upper, lower, screw, post = range(4)
    blades = scissors(screw_at=(0.1, 0.03))
    features = compute_candidate_features(blades, [(upper,), (lower,), (screw,), (post,)])
    for group in (upper, lower):
        rows = features.rows(group)
        upright = (features.kinds[rows] == JointKind.REVOLUTE.code) & (np.abs(features.directions[rows] @ UP) > 0.999)
        distances = np.linalg.norm((features.pivots[rows] - [0.1, 0.0, 0.03])[:, [0, 2]], axis=1)
        assert (upright & (distances < 1e-3)).sum() == 1
        assert np.sort(distances[upright])[1] > 0.02
    assert len(blades.round_pieces) == 2
    groups = group_geometries(blades, [[upper], [screw], [lower, screw]])
    assert [(len(group.own_round), len(group.neighbour_round)) for group in groups] == [(0, 1), (1, 0), (1, 0)]


def test_the_round_pieces_nearest_to_the_contact_are_kept() -> None:
    leaves = np.zeros(20, int)
    middles = np.column_stack([np.arange(20.0), np.zeros(20), np.zeros(20)])
    many = RoundPieces(leaves, middles, np.tile(UP, (20, 1)), np.full(20, 0.1), np.full(20, 0.2))
    kept = many.nearest_to(np.array([12.0, 5.0, 0.0]))
    assert len(kept) == MAX_PIECES
    assert kept.middles[:, 0].tolist() == list(range(12 - MAX_PIECES // 2, 12 + MAX_PIECES // 2))
