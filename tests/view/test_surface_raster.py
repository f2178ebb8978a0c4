"""Surfaces that a camera sees, against the geometry of spheres and against the renderer of scans."""

from __future__ import annotations

import numpy as np
import trimesh

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.view.picture_raster import DISTANCE, FAR, NEAR, Camera, front_left
from kinmo.view.surface_raster import BATCH, NOTHING, SurfaceRaster

SIZE = 90
UP = np.array([0.0, 1.0, 0.0])


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.array(solid.vertices), np.array(solid.faces, np.uint32))


def camera_of(meshes: list[Mesh]) -> Camera:
    return front_left(np.concatenate([mesh.vertices for mesh in meshes]), UP, SIZE)


def test_a_sphere_has_its_depths_and_normals() -> None:
    ball = mesh_of(trimesh.creation.icosphere(4))
    assert len(ball.faces) > 2 * BATCH, "several batches"
    camera = camera_of([ball])
    seen = SurfaceRaster([ball]).render(camera, np.eye(4)[None], 2)
    rows, columns = np.nonzero(seen.is_seen)
    focal, center = 2 * camera.focal, 2 * camera.center
    rays = np.stack([(columns + 0.5 - center[0]) / focal, (rows + 0.5 - center[1]) / focal, np.ones(len(rows))], axis=1)
    points = rays * seen.depths[rows, columns][:, None]
    away = points - [0.0, 0.0, DISTANCE]
    radius = 1.0 / camera.radius
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), radius, rtol=0.01)
    cosines = np.einsum("ij,ij->i", seen.normals[rows, columns], away / np.linalg.norm(away, axis=1, keepdims=True))
    assert np.quantile(cosines, 0.02) > 0.999


def test_parts_are_those_of_the_renderer_of_scans() -> None:
    rng = np.random.default_rng(1)
    solids = [trimesh.creation.icosphere(2, radius) for radius in (0.5, 0.8, 0.6)]
    meshes = [Mesh(np.array(s.vertices) + rng.normal(size=3), np.array(s.faces, np.uint32)) for s in solids]
    camera = camera_of(meshes)
    found = SurfaceRaster(meshes).render(camera, np.tile(np.eye(4), (3, 1, 1)))
    views = _core.Meshes([camera.to_view(mesh.vertices) for mesh in meshes], [mesh.faces for mesh in meshes])
    poses = np.tile(np.eye(4), (1, 3, 1, 1))
    depths, parts = _core.render(views, poses, (SIZE, SIZE), np.full(2, camera.focal), camera.center, near=NEAR, far=FAR)
    assert (found.parts == parts[0]).mean() > 0.999
    both = found.is_seen & (parts[0] >= 0)
    np.testing.assert_allclose(found.depths[both], depths[0][both], atol=0.01)


def test_a_pose_moves_a_part() -> None:
    box = mesh_of(trimesh.creation.box())
    camera = camera_of([box])
    pose = np.eye(4)
    pose[:3, 3] = [0.2, -0.1, 0.3]
    moved = Mesh(box.vertices + pose[:3, 3], box.faces)
    one, other = SurfaceRaster([box]).render(camera, pose[None]), SurfaceRaster([moved]).render(camera, np.eye(4)[None])
    np.testing.assert_array_equal(one.parts, other.parts)
    np.testing.assert_allclose(one.normals, other.normals, atol=1e-6)


def test_of_surfaces_in_one_place_that_of_the_higher_rank_is_seen() -> None:
    box = mesh_of(trimesh.creation.box())
    raster, camera, poses = SurfaceRaster([box, box]), camera_of([box]), np.tile(np.eye(4), (2, 1, 1))
    for ranks, wanted in (((0, 1), 1), ((1, 0), 0)):
        assert set(np.unique(raster.render(camera, poses, ranks=ranks).parts)) == {NOTHING, wanted}


def test_nothing_is_seen_of_nothing() -> None:
    camera = camera_of([mesh_of(trimesh.creation.box())])
    assert not SurfaceRaster([]).render(camera, np.zeros((0, 4, 4))).is_seen.any()
