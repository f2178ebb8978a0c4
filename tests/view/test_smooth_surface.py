"""Normals for shading: round surfaces are smooth, and creases are sharp."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from kinmo.core.shape import Mesh
from kinmo.view.smooth_surface import corner_normals, with_sharp_creases


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.array(solid.vertices), np.array(solid.faces, np.uint32))


def test_a_sphere_has_the_normals_of_a_sphere() -> None:
    ball = mesh_of(trimesh.creation.icosphere(3))
    np.testing.assert_allclose(
        corner_normals(ball), ball.triangles / np.linalg.norm(ball.triangles, axis=-1, keepdims=True), atol=0.02
    )


@pytest.mark.parametrize("is_welded", [True, False])
def test_a_box_has_the_normals_of_its_sides(is_welded: bool) -> None:
    solid = trimesh.creation.box((1.0, 2.0, 3.0))
    if not is_welded:
        solid.unmerge_vertices()
    normals = corner_normals(mesh_of(solid))
    np.testing.assert_allclose(normals, np.repeat(solid.face_normals[:, None], 3, axis=1), atol=1e-12)


def test_a_cylinder_is_round_at_its_side_and_flat_at_its_ends() -> None:
    tube = mesh_of(trimesh.creation.cylinder(1.0, 2.0, sections=32))
    corners, normals = tube.triangles.reshape(-1, 3), corner_normals(tube).reshape(-1, 3)
    is_end = np.repeat(np.ptp(tube.triangles[..., 2], axis=1) < 1e-9, 3)
    np.testing.assert_allclose(np.abs(normals[is_end, 2]), 1.0, atol=1e-9)
    radial = corners[~is_end] * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(normals[~is_end], radial, atol=0.11)


def test_faces_keep_their_places_and_share_vertices_only_where_round() -> None:
    box = mesh_of(trimesh.creation.box())
    vertices, faces = with_sharp_creases(box)
    np.testing.assert_allclose(vertices[faces], box.triangles, atol=1e-9)
    assert len(vertices) == 24
    ball = mesh_of(trimesh.creation.icosphere(2))
    assert len(with_sharp_creases(ball)[0]) == len(ball.vertices)


def test_a_mesh_without_area_has_finite_normals() -> None:
    assert np.isfinite(corner_normals(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.uint32)))).all()
    assert corner_normals(Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))).shape == (0, 3, 3)
