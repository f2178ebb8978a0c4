"""Loose pieces of a mesh."""

from __future__ import annotations

import numpy as np
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.loose_pieces import loose_pieces, pieces_of_faces, same_vertices
from kinmo.core.shape import Mesh, join


def box(x: float, size: float = 0.2) -> Mesh:
    solid = trimesh.creation.box((size, size, size)).apply_translation([x, 0.0, 0.0])
    return Mesh(np.array(solid.vertices), np.array(solid.faces, np.uint32))


def unwelded(mesh: Mesh) -> Mesh:
    """The mesh with vertices of their own for every face, as flat shading needs."""
    return Mesh(mesh.vertices[mesh.faces.ravel()], np.arange(mesh.faces.size, dtype=np.uint32).reshape(-1, 3))


def test_separate_boxes_are_pieces_and_the_largest_comes_first() -> None:
    pieces = loose_pieces(unwelded(join(box(0.0, 0.1), box(1.0, 0.3), box(2.0, 0.2))))
    assert [round(float(np.ptp(piece.vertices[:, 0])), 6) for piece in pieces] == [0.3, 0.2, 0.1]


def test_boxes_that_share_an_edge_are_one_piece() -> None:
    assert len(loose_pieces(join(box(0.0), box(0.2)))) == 1


@given(count=st.integers(1, 6), most=st.integers(1, 8), seed=st.integers(0, 2**31))
def test_every_face_is_in_one_piece_and_there_are_not_too_many(count: int, most: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    whole = unwelded(join(*(box(0.5 * i, rng.uniform(0.05, 0.3)) for i in range(count))))
    shuffled = Mesh(whole.vertices, rng.permutation(whole.faces))
    pieces = loose_pieces(shuffled, most=most)
    assert len(pieces) == min(count, most)
    assert sum(len(piece.faces) for piece in pieces) == len(shuffled.faces)
    assert np.isclose(sum(piece.face_areas.sum() for piece in pieces), shuffled.face_areas.sum())
    assert pieces_of_faces(shuffled, most=most).max() == len(pieces) - 1


def test_trimesh_finds_the_same_pieces() -> None:
    whole = join(box(0.0), box(0.1, 0.05), box(1.0))
    others = trimesh.Trimesh(whole.vertices, whole.faces).split(only_watertight=False)
    ours = sorted(round(float(piece.face_areas.sum()), 9) for piece in loose_pieces(whole))
    assert ours == sorted(round(float(other.area), 9) for other in others)


@given(far=st.sampled_from([-1e9, -1.0, 1e9]), seed=st.integers(0, 2**31))
def test_vertices_without_a_face_do_not_change_which_vertices_are_the_same(far: float, seed: int) -> None:
    whole = unwelded(join(box(0.0), box(np.random.default_rng(seed).uniform(0.0, 1.0))))
    with_far = Mesh(np.concatenate([whole.vertices, [[0.0, far, 0.0]]]), whole.faces)
    (corners, places, step), (also, also_places, also_step) = same_vertices(whole), same_vertices(with_far)
    assert step == also_step
    np.testing.assert_array_equal(places[corners], also_places[also])
