"""Agreement of the two renderers."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scanned_objects import UP, cupboard_object

from kinmo.core.kinematics import forward
from kinmo.core.shape import Mesh
from kinmo.scans.rendering.labelled_frames import sample_joint_states
from kinmo.scans.rendering.pinhole_camera import Camera, Viewpoints
from kinmo.scans.rendering.renderers import NO_PART, open_renderer

CAMERA = Camera(160, 120, np.array([110.0, 115.0]), np.array([77.0, 66.0]), 0.01, 10.0)


def test_pybullet_and_the_z_buffer_give_equal_images() -> None:
    target, rng = cupboard_object(), np.random.default_rng(0)
    states = list(sample_joint_states(target.mobility, 6, rng))
    cameras = [Viewpoints(target_offset=0.0).sample(rng, np.zeros(3), 0.5, target.up) for _ in states]
    poses = np.stack([pose @ forward(target.mobility, *s) for s, pose in zip(states, cameras, strict=True)])
    with open_renderer("raster", target.meshes) as ours, open_renderer("pybullet", target.meshes) as theirs:
        mine, reference = ours.render(poses, CAMERA), theirs.render(poses, CAMERA)
    assert (mine.parts != NO_PART).mean() > 0.05
    assert (mine.parts == reference.parts).mean() >= 0.999
    both = (mine.parts == reference.parts) & (mine.parts != NO_PART)
    assert np.abs(mine.depths - reference.depths)[both].max() < 1e-4 * (CAMERA.far - CAMERA.near)
    assert (mine.depths[mine.parts == NO_PART] == 0.0).all()
    assert {int(part) for part in np.unique(mine.parts)} == {NO_PART, 0, 1, 2, 3}


def test_the_renderers_agree_on_thousands_of_small_triangles() -> None:
    rng = np.random.default_rng(1)
    round_things = trimesh.creation.icosphere(4, 0.3), trimesh.creation.torus(0.4, 0.08, 64, 48)
    meshes = [Mesh(np.asarray(each.vertices), np.asarray(each.faces, np.uint32)) for each in round_things]
    cameras = np.stack([Viewpoints().sample(rng, np.zeros(3), 0.5, UP) for _ in range(6)])
    poses = np.repeat(cameras[:, None], len(meshes), axis=1)
    with open_renderer("raster", meshes) as ours, open_renderer("pybullet", meshes) as theirs:
        mine, reference = ours.render(poses, CAMERA), theirs.render(poses, CAMERA)
    are_equal, seen = mine.parts == reference.parts, (mine.parts != NO_PART) | (reference.parts != NO_PART)
    assert seen.mean() > 0.2
    assert are_equal[seen].mean() >= 0.999
    assert np.abs(mine.depths - reference.depths)[are_equal & seen].max() < 1e-4 * (CAMERA.far - CAMERA.near)


def test_triangles_are_visible_from_both_sides() -> None:
    plate = Mesh(np.array([[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [0.0, 1.0, 2.0]]), np.array([[0, 1, 2]], np.uint32))
    back = Mesh(plate.vertices, plate.faces[:, ::-1].copy())
    for name in ("raster", "pybullet"):
        seen = []
        for mesh in (plate, back):
            with open_renderer(name, [mesh]) as renderer:
                seen.append(renderer.render(np.eye(4)[None, None], CAMERA).parts)
        assert (seen[0] == 0).sum() > 1000
        np.testing.assert_array_equal(*seen)


def test_two_open_renderers_are_independent() -> None:
    target = cupboard_object()
    pose = Viewpoints().sample(np.random.default_rng(1), np.zeros(3), 0.5, target.up)
    poses = np.tile(pose, (1, 1, 1, 1))
    with open_renderer("pybullet", target.meshes) as whole, open_renderer("pybullet", target.meshes[:1]) as base:
        assert base.render(poses, CAMERA).parts.max() == 0
        assert whole.render(np.tile(pose, (1, 4, 1, 1)), CAMERA).parts.max() > 0
    with pytest.raises(ValueError, match="transforms"), open_renderer("raster", target.meshes) as raster:
        raster.render(poses, CAMERA)
