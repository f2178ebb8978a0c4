"""Depth and part images."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo import _core

SIZE, FOCAL, CENTER = (48, 32), np.array([40.0, 38.0]), np.array([23.7, 16.2])
NEAR, FAR = 0.1, 20.0


def picture(meshes: list[trimesh.Trimesh], transforms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    core = _core.Meshes(
        [m.vertices.view(np.ndarray).astype(float) for m in meshes], [m.faces.astype(np.uint32) for m in meshes]
    )
    return _core.render(core, transforms, SIZE, FOCAL, CENTER, near=NEAR, far=FAR)


def rays() -> np.ndarray:
    """Directions [height, width, 3] through the middles of the pixels, with z = 1."""
    columns, rows = np.meshgrid(np.arange(SIZE[0]) + 0.5, np.arange(SIZE[1]) + 0.5)
    return np.stack([(columns - CENTER[0]) / FOCAL[0], (rows - CENTER[1]) / FOCAL[1], np.ones_like(rows)], axis=-1)


def solids(rng: np.random.Generator, count: int) -> list[trimesh.Trimesh]:
    made = []
    for _ in range(count):
        extents = rng.uniform(0.2, 1.0, 3)
        solid = trimesh.creation.box(extents) if rng.random() < 0.5 else trimesh.creation.icosphere(2, extents[0])
        made.append(solid)
    return made


def poses(rng: np.random.Generator, frames: int, parts: int) -> np.ndarray:
    found = np.tile(np.eye(4), (frames, parts, 1, 1))
    for frame in found.reshape(-1, 4, 4):
        frame[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        frame[:3, 3] = rng.uniform([-1.0, -1.0, 1.5], [1.0, 1.0, 4.0])
    return found


def first_hits(mesh: trimesh.Trimesh, directions: np.ndarray) -> np.ndarray:
    """Depth [n] at which rays [n, 3] from the origin first meet a triangle of `mesh`, inf where they meet none."""
    a, b, c = np.swapaxes(mesh.vertices.view(np.ndarray)[mesh.faces], 0, 1)
    normals = np.cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        depths = np.sum(normals * a, axis=1) / (directions @ normals.T)
        places = depths[..., None] * directions[:, None]
        sides = [np.sum(np.cross(v - u, places - u) * normals, axis=-1) >= 0.0 for u, v in ((a, b), (b, c), (c, a))]
    return np.where(np.logical_and.reduce(sides) & (depths > 0.0), depths * directions[:, 2:], np.inf).min(axis=1)


@settings(max_examples=6)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_pictures_are_those_of_rays_through_the_middles_of_the_pixels(seed: int, parts: int) -> None:
    rng = np.random.default_rng(seed)
    meshes, transforms = solids(rng, parts), poses(rng, 2, parts)
    depths, seen = picture(meshes, transforms)
    assert depths.shape == seen.shape == (2, SIZE[1], SIZE[0])
    assert (depths.dtype, seen.dtype) == (np.float32, np.int32)
    directions = rays().reshape(-1, 3)
    for frame in range(2):
        moved = [mesh.copy().apply_transform(transforms[frame, part]) for part, mesh in enumerate(meshes)]
        expected = np.stack([first_hits(mesh, directions) for mesh in moved])
        nearest = expected.min(axis=0)
        there = np.isfinite(nearest)
        agree = there == (seen[frame].ravel() >= 0)
        assert agree.mean() > 0.995  # rays along an edge go either way
        both = there & agree
        off = np.abs(depths[frame].ravel()[both] - nearest[both])
        assert np.mean(off < 1e-4 * FAR) > 0.995
        assert np.mean(expected.argmin(axis=0)[both] == seen[frame].ravel()[both]) > 0.99


def test_frames_are_pictures_of_their_own_and_do_not_depend_on_each_other() -> None:
    rng = np.random.default_rng(0)
    meshes, transforms = solids(rng, 3), poses(rng, 5, 3)
    together = picture(meshes, transforms)
    for frame in range(5):
        alone = picture(meshes, transforms[frame : frame + 1])
        np.testing.assert_array_equal(alone[0][0], together[0][frame])
        np.testing.assert_array_equal(alone[1][0], together[1][frame])
    assert picture(meshes, transforms[:0])[0].shape == (0, SIZE[1], SIZE[0])


def test_what_is_behind_too_near_or_too_far_is_not_seen() -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    for z, is_seen in ((3.0, True), (-3.0, False), (30.0, False), (0.3, True)):
        transform = np.eye(4)
        transform[2, 3] = z
        depths, parts = picture([box], transform[None, None])
        assert (parts >= 0).any() == is_seen
        assert (depths[parts >= 0] >= NEAR).all() and (depths[parts < 0] == 0.0).all()
        if z == 0.3:  # the camera is inside: it sees the far wall
            assert (parts == 0).all()
            np.testing.assert_allclose(depths.max(), 0.8, rtol=1e-5)


@pytest.mark.parametrize(
    ("argument", "values"),
    [
        ("size", {"size": (0, 4)}),
        ("focal", {"focal": np.array([1.0, -1.0])}),
        ("center", {"center": np.array([1.0, np.nan])}),
        ("near", {"near": 0.0}),
        ("near", {"near": 5.0, "far": 4.0}),
        ("transforms", {"transforms": np.zeros((1, 2, 4, 4))}),
        ("transforms", {"transforms": np.full((1, 1, 4, 4), np.inf)}),
    ],
)
def test_what_cannot_be_rendered_is_refused_by_name(argument: str, values: dict[str, object]) -> None:
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    core = _core.Meshes([np.array(box.vertices)], [np.array(box.faces, np.uint32)])
    given = {"transforms": np.eye(4)[None, None], "size": SIZE, "focal": FOCAL, "center": CENTER, "near": NEAR, "far": FAR}
    with pytest.raises(ValueError, match=f"^{argument}"):
        _core.render(core, **{**given, **values})
