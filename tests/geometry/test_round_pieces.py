"""`find_round_pieces`: what a mesh has that turns by any angle about a line, however it lies, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import BOX, CYLINDER, DEGENERATE, F64, MeshArrays, arrays, clouds, meshes, moved, rotation, seeds

from kinmo import _core

PIN = arrays(trimesh.creation.cylinder(0.2, 1.0, sections=24))
RING = arrays(trimesh.creation.torus(1.0, 0.1, major_sections=32, minor_sections=12))
CONE = arrays(trimesh.creation.cone(0.5, 1.5, sections=32))
BALL = arrays(trimesh.creation.icosphere(3))
UPRIGHT = np.array([0.0, 0.0, 1.0])


def together(*parts: MeshArrays) -> MeshArrays:
    """Several pieces as one mesh."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts[:-1])])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces).astype(np.uint32)


def split_at_faces(part: MeshArrays) -> MeshArrays:
    """The same with vertices of its own for every face, as files that keep normals by vertex have it."""
    return part[0][part[1]].reshape(-1, 3), np.arange(3 * len(part[1]), dtype=np.uint32).reshape(-1, 3)


def line_error(middle: F64, direction: F64, point: F64, true: F64) -> float:
    return float(np.linalg.norm(np.cross(middle - point, true))) + float(np.linalg.norm(np.cross(direction, true)))


@settings(max_examples=40)
@given(seeds, st.sampled_from([PIN, RING, CONE, CYLINDER]), st.booleans(), st.floats(0.01, 100.0))
def test_a_round_piece_is_found_among_others_however_it_lies(seed: int, piece: MeshArrays, splits: bool, scale: float) -> None:
    beside = moved(BOX, np.eye(3), np.array([9.0, 0.0, 0.0]))
    turn = rotation(seed)
    whole = moved(together(beside, piece), turn, 3.0, scale)
    mesh, middles, directions, radii, half_lengths = _core.find_round_pieces(
        meshes(BOX, split_at_faces(whole) if splits else whole), seed=seed
    )
    assert mesh.tolist() == [1]
    low, high = piece[0].min(axis=0), piece[0].max(axis=0)
    at = scale * turn @ (0.5 * (low + high)) + 3.0
    size = scale * float(np.linalg.norm(high - low))
    assert line_error(middles[0], directions[0], at, turn @ UPRIGHT) < 0.02 * (size + 1.0)
    np.testing.assert_allclose(radii[0], scale * high[0], rtol=0.05)
    np.testing.assert_allclose(half_lengths[0], 0.5 * scale * (high - low)[2], rtol=0.05)


def test_the_pieces_of_a_mesh_are_told_apart() -> None:
    knuckles = [moved(PIN, np.eye(3), np.array([0.0, 0.0, 1.5 * place])) for place in range(3)]
    mesh, middles, directions, _, _ = _core.find_round_pieces(meshes(together(*knuckles), CONE))
    assert mesh.tolist() == [0, 0, 0, 1]
    np.testing.assert_allclose(middles[:3], [[0, 0, 0], [0, 0, 1.5], [0, 0, 3]], atol=1e-6)
    np.testing.assert_allclose(np.abs(directions @ UPRIGHT), 1.0, atol=1e-6)


@pytest.mark.parametrize("part", [BOX, BALL, *DEGENERATE.values()], ids=["box", "ball", *DEGENERATE])
def test_what_is_round_about_no_line_or_about_any_has_none(part: MeshArrays) -> None:
    assert [len(values) for values in _core.find_round_pieces(meshes(part))] == [0] * 5


@settings(max_examples=40)
@given(clouds(), seeds)
def test_what_is_found_anywhere_is_finite(part: MeshArrays, seed: int) -> None:
    mesh, middles, directions, radii, half_lengths = _core.find_round_pieces(meshes(part), seed=seed)
    assert all(np.isfinite(values).all() for values in (middles, directions, radii, half_lengths))
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), np.ones(len(mesh)))
