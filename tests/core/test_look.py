"""Looks of meshes follow their faces through everything that changes meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.core.look import NO_MATERIAL, Look, Material
from kinmo.core.loose_pieces import loose_pieces
from kinmo.core.mesh_splitting import split_mesh
from kinmo.core.shape import Mesh, join

WOOD, STEEL = Material("wood"), Material("steel", metallic=1.0)


def random_mesh(seed: int, faces: int = 12, materials: tuple[Material, ...] = (WOOD, STEEL)) -> Mesh:
    """A mesh of random triangles whose texture coordinates are x and y, whose colours are z, and whose normals are right."""
    rng = np.random.default_rng(seed)
    vertices = rng.uniform(0.0, 1.0, (faces + 3, 3))
    corners = np.array([rng.choice(len(vertices), 3, replace=False) for _ in range(faces)], np.uint32)
    triangles = vertices[corners]
    colors = np.repeat(triangles[..., 2:], 4, axis=2).astype(np.float32)
    look = Look(
        materials, rng.integers(-1, len(materials), faces).astype(np.int32), triangles[..., :2], colors, across(triangles)
    )
    return Mesh(vertices, corners, look)


def across(triangles: np.ndarray) -> np.ndarray:
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.repeat(normals[:, None], 3, axis=1).astype(np.float32)


def materials_of(mesh: Mesh) -> list[Material | None]:
    assert mesh.look is not None
    return [None if i == NO_MATERIAL else mesh.look.materials[i] for i in mesh.look.material]


def assert_fits(mesh: Mesh) -> None:
    """The corners of the look belong to those of the faces."""
    assert (
        mesh.look is not None and mesh.look.uvs is not None and mesh.look.colors is not None and mesh.look.normals is not None
    )
    np.testing.assert_array_equal(mesh.look.uvs, mesh.triangles[..., :2])
    np.testing.assert_allclose(mesh.look.colors[..., 0], mesh.triangles[..., 2], atol=1e-7)
    np.testing.assert_allclose(mesh.look.normals, across(mesh.triangles), atol=1e-6)


@given(st.integers(0, 50))
def test_parts_splits_and_joins_keep_looks(seed: int) -> None:
    one, other = random_mesh(seed), random_mesh(seed + 1, 7, (STEEL,))
    labels = np.random.default_rng(seed).integers(0, 3, 12)
    for mesh in (one.compact, one.part(labels == labels[0]), one.part(np.arange(12)[::-1]), join(one, other), one.flipped):
        assert_fits(mesh)
    for piece in [*split_mesh(one, labels), *loose_pieces(one)]:
        assert_fits(piece)
    assert materials_of(join(one, other)) == [*materials_of(one), *materials_of(other)]
    assert len(join(one, other).look.materials) == 2
    order = np.argsort(labels, kind="stable")
    split = [material for piece in split_mesh(one, labels) for material in materials_of(piece)]
    assert split == [materials_of(one)[i] for i in order]


@given(st.integers(0, 50))
def test_normals_turn_with_the_faces_under_any_map(seed: int) -> None:
    mesh, rng = random_mesh(seed), np.random.default_rng(seed)
    linear = Rotation.random(rng=rng).as_matrix() @ np.diag(rng.uniform(0.5, 2.0, 3) * rng.choice([-1.0, 1.0], 3))
    moved = mesh.moved(linear, rng.uniform(-1.0, 1.0, 3))
    assert moved.look is not None and moved.look.normals is not None
    np.testing.assert_allclose(moved.look.normals, across(moved.triangles), atol=1e-4)


def test_joining_with_a_bare_mesh_fills_in_what_it_lacks() -> None:
    mesh = random_mesh(0)
    whole = join(mesh.bare, mesh)
    assert whole.look is not None and whole.look.uvs is not None and whole.look.colors is not None
    assert materials_of(whole) == [None] * 12 + materials_of(mesh)
    assert (whole.look.colors[:12] == 1.0).all() and (whole.look.uvs[:12] == 0.0).all()
    np.testing.assert_allclose(whole.look.normals, across(whole.triangles), atol=1e-6)
    assert join(mesh.bare, mesh.bare).look is None


def test_a_map_to_a_plane_drops_normals_that_it_cannot_turn() -> None:
    flat = random_mesh(0).moved(np.diag([1.0, 0.0, 0.0]), 0.0)
    assert flat.look is not None and flat.look.normals is None and flat.look.uvs is not None


def test_used_materials_are_those_of_faces() -> None:
    look = Look((WOOD, STEEL), np.array([1, NO_MATERIAL, 1], np.int32))
    assert [(material, faces.tolist()) for material, faces in look.used()] == [
        (None, [False, True, False]),
        (STEEL, [True, False, True]),
    ]


@pytest.mark.parametrize("faces", [np.array([2, 0]), np.array([True, False, True] + [False] * 9)])
def test_some_faces_keep_their_own_materials(faces: np.ndarray) -> None:
    mesh = random_mesh(3)
    chosen = faces if faces.dtype != bool else np.flatnonzero(faces)
    assert materials_of(mesh.part(faces)) == [materials_of(mesh)[i] for i in chosen]


def test_some_faces_have_no_materials_of_others() -> None:
    look = Look((WOOD, STEEL), np.array([1, NO_MATERIAL, 1, 0], np.int32))
    for chosen, materials, numbers in (
        ([0, 1, 2], (STEEL,), [0, NO_MATERIAL, 0]),
        ([2, 0], (STEEL,), [0, 0]),
        ([1], (), [NO_MATERIAL]),
        ([0, 3], (WOOD, STEEL), [1, 0]),
        ([], (), []),
    ):
        found = look.of_faces(np.array(chosen, int))
        assert (found.materials, found.material.tolist(), found.material.dtype) == (materials, numbers, np.int32)
