"""`sample_surface`: uniform by area, on the surface, the same for a seed whatever else is going on."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from scipy.stats import chisquare, ks_1samp
from solids import BOX, CYLINDER, DEGENERATE, F64, LINE, POINT, RECTANGLE, MeshArrays, arrays, clouds, meshes, seeds

from kinmo import _core


def distance_to_faces(points: F64, part: MeshArrays, faces: np.ndarray) -> F64:
    corners = part[0][part[1][faces]]
    return np.linalg.norm(trimesh.triangles.closest_point(corners, points) - points, axis=1)


@given(part=clouds(), seed=seeds, blue_noise=st.booleans())
@settings(max_examples=60)
def test_samples_lie_on_their_faces_with_unit_normals(part: MeshArrays, seed: int, blue_noise: bool) -> None:
    points, normals, faces = (a[0] for a in _core.sample_surface(meshes(part), 50, seed, blue_noise=blue_noise))
    size = np.abs(part[0]).max()
    corners = part[0][part[1][faces]]
    edges = corners[:, 1:] - corners[:, :1]
    sides = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    solid = sides > 1e-9 * size**2
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-5)
    assert (distance_to_faces(points[solid].astype(float), part, faces[solid]) < 1e-5 * size).all()
    across = np.abs(np.einsum("nd,nkd->nk", normals, edges)).max(axis=1)
    assert (across[solid] < 1e-4 * size).all()


@given(seed=seeds)
@settings(max_examples=10)
def test_faces_get_samples_by_their_area(seed: int) -> None:
    mesh = trimesh.creation.cone(1.0, 3.0, sections=20)
    faces = _core.sample_surface(meshes(arrays(mesh)), 5000, seed)[2][0]
    expected = 5000 * mesh.area_faces / mesh.area
    # Stratified draws vary less than independent ones, so that this fails only where the areas are wrong.
    assert chisquare(np.bincount(faces, minlength=len(expected)), expected).pvalue > 1e-3


@pytest.mark.parametrize("triangles", [2, 50, 20_000])
def test_points_are_uniform_within_and_across_faces(triangles: int) -> None:
    strips = np.linspace(0.0, 1.0, triangles // 2 + 1) ** 2  # of very different widths
    vertices = np.array([[x, y, 0.0] for x in strips for y in (0.0, 1.0)])
    first = 2 * np.arange(triangles // 2)[:, None]
    faces = np.concatenate([first + [0, 2, 1], first + [1, 2, 3]])
    points = _core.sample_surface(meshes((vertices, faces.astype(np.uint32))), 2000, 7)[0][0]
    for axis in range(2):
        assert ks_1samp(points[:, axis], lambda x: np.clip(x, 0.0, 1.0)).pvalue > 1e-3


def test_every_prefix_is_uniform_too() -> None:
    points = _core.sample_surface(meshes(RECTANGLE), 4096, 3)[0][0]
    for count in (64, 512):
        assert ks_1samp(points[:count, 0] / 2.0, lambda x: np.clip(x, 0.0, 1.0)).pvalue > 1e-3


@given(seed=seeds, blue_noise=st.booleans())
@settings(max_examples=10)
def test_samples_of_a_mesh_do_not_depend_on_the_others(seed: int, blue_noise: bool) -> None:
    alone = _core.sample_surface(meshes(CYLINDER), 100, seed, blue_noise=blue_noise)
    among = _core.sample_surface(meshes(BOX, CYLINDER, RECTANGLE), 100, seed, blue_noise=blue_noise)
    for a, b in zip(alone, among, strict=True):
        np.testing.assert_array_equal(a[0], b[1])


def test_seeds_give_different_samples() -> None:
    first, second = (_core.sample_surface(meshes(BOX), 100, seed)[0] for seed in (0, 1))
    assert not np.array_equal(first, second)


def test_blue_noise_keeps_samples_apart() -> None:
    def nearest(blue_noise: bool) -> F64:
        points = _core.sample_surface(meshes(CYLINDER), 1024, 5, blue_noise=blue_noise)[0][0]
        return cKDTree(points).query(points, 2)[0][:, 1]

    plain, even = nearest(False), nearest(True)
    assert even.min() > 5 * plain.min()
    assert even.mean() > 1.5 * plain.mean()
    # Spread over the whole surface, not thinned somewhere.
    assert even.max() < 3 * even.mean()


def test_a_line_is_sampled_by_length() -> None:
    points, normals, _ = (a[0] for a in _core.sample_surface(meshes(LINE), 2000, 1))
    along = points @ np.array([1.0, 1.0, 2.0]) / 18.0
    np.testing.assert_allclose(points, along[:, None] * [3.0, 3.0, 6.0], atol=1e-5)
    # The edges 0-1, 1-2 and 2-0 cover each piece twice.
    assert ks_1samp(along, lambda x: np.clip(x, 0.0, 1.0)).pvalue > 1e-3
    np.testing.assert_allclose(normals @ [1.0, 1.0, 2.0], 0.0, atol=1e-5)


def test_a_point_is_sampled_at_its_place() -> None:
    points, normals, _ = _core.sample_surface(meshes(POINT), 10)
    np.testing.assert_array_equal(points[0], np.tile([1, 2, 3], (10, 1)))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0)


@pytest.mark.parametrize("part", DEGENERATE.values(), ids=DEGENERATE)
@pytest.mark.parametrize(("shift", "scale"), [(0.0, 1.0), (1e6, 1.0), (0.0, 1e8), (0.0, 1e-8)])
@pytest.mark.parametrize("blue_noise", [False, True])
def test_degenerate_far_huge_and_tiny_meshes_are_sampled(
    part: MeshArrays, shift: float, scale: float, blue_noise: bool
) -> None:
    points, normals, faces = _core.sample_surface(meshes((part[0] * scale + shift, part[1])), 64, blue_noise=blue_noise)
    low, high = (part[0] * scale + shift).min(axis=0), (part[0] * scale + shift).max(axis=0)
    margin = 1e-6 * (abs(shift) + 10 * scale)
    assert ((points >= low - margin) & (points <= high + margin)).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, atol=1e-5)
    assert faces.max() < len(part[1])


@pytest.mark.parametrize("count", [0, -1, 10**12])
def test_a_count_that_makes_no_sense_is_refused(count: int) -> None:
    with pytest.raises(ValueError, match="count"):
        _core.sample_surface(meshes(BOX), count)


def test_coordinates_beyond_single_precision_are_refused() -> None:
    with pytest.raises(ValueError, match=r"meshes\[1\]"):
        _core.sample_surface(meshes(BOX, (BOX[0] * 1e39, BOX[1])), 10)


def test_the_number_of_threads_changes_nothing() -> None:
    script = (
        "import hashlib, numpy as np\n"
        "from kinmo import _core\n"
        "rng = np.random.default_rng(0)\n"
        "faces = [rng.integers(0, 40, (60, 3), dtype=np.uint32) for _ in range(23)]\n"
        "meshes = _core.Meshes([rng.normal(size=(40, 3)) for _ in faces], faces)\n"
        "groups = [[i, (i + 1) % 23] for i in range(23)]\n"
        "found = [*_core.sample_surface(meshes, 200, 4), *_core.sample_surface(meshes, 50, 4, blue_noise=True)]\n"
        "found += [*_core.fit_boxes(meshes, groups), *_core.fit_symmetric_boxes(meshes)]\n"
        "found += [*_core.fit_aligned_boxes(meshes, np.eye(3))]\n"
        "found += [*_core.find_symmetries(meshes, groups), *_core.find_round_pieces(meshes)]\n"
        "print(hashlib.sha256(b''.join(a.tobytes() for a in found)).hexdigest())\n"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "RAYON_NUM_THREADS": threads, "PYTHONHASHSEED": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "3")
    }
    assert len(outputs) == 1
