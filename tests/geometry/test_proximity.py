"""Nearest places on surfaces."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from trimesh.triangles import closest_point

from kinmo import _core


def solids(seed: int) -> tuple[_core.Meshes, list[trimesh.Trimesh]]:
    rng = np.random.default_rng(seed)
    made = [trimesh.creation.box(rng.uniform(0.1, 1, 3)), trimesh.creation.icosphere(subdivisions=1, radius=0.4)]
    for mesh in made:
        mesh.apply_translation(rng.uniform(-1, 1, 3))
    return _core.Meshes([np.array(m.vertices) for m in made], [np.array(m.faces, np.uint32) for m in made]), made


@settings(max_examples=30)
@given(st.integers(0, 10_000))
def test_nearest_places_agree_with_trimesh(seed: int) -> None:
    meshes, made = solids(seed)
    points = np.random.default_rng(seed + 1).uniform(-2, 2, (40, 3))
    distances, places, normals = _core.closest_points(meshes, [0, 1], points)
    triangles = np.concatenate([mesh.triangles for mesh in made])
    expected = [np.linalg.norm(closest_point(triangles, np.tile(p, (len(triangles), 1))) - p, axis=1).min() for p in points]
    np.testing.assert_allclose(distances, expected, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(points - places, axis=1), distances, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-9)


@given(st.integers(0, 10_000))
def test_groups_have_the_nearest_places_of_each_alone(seed: int) -> None:
    meshes, _ = solids(seed)
    groups = [[0], [1], [0, 1], [1, 0], [0]]
    points = np.random.default_rng(seed + 1).uniform(-2, 2, (len(groups), 7, 3))
    alone = [_core.closest_points(meshes, group, own) for group, own in zip(groups, points, strict=True)]
    for found, expected in zip(_core.closest_points_of_groups(meshes, groups, points), zip(*alone, strict=True), strict=True):
        np.testing.assert_array_equal(found, np.array(expected))


@given(st.sampled_from([1e-8, 1.0, 1e8]), st.integers(0, 100))
def test_any_scale_gives_the_same_places(scale: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    vertices, faces = rng.normal(size=(6, 3)), np.array([[0, 1, 2], [3, 4, 5]], np.uint32)
    points = rng.normal(size=(5, 3))
    one = _core.closest_points(_core.Meshes([vertices], [faces]), [0], points)
    other = _core.closest_points(_core.Meshes([vertices * scale], [faces]), [0], points * scale)
    np.testing.assert_allclose(other[0] / scale, one[0], rtol=1e-9)
    np.testing.assert_allclose(other[1] / scale, one[1], atol=1e-9)


def test_a_triangle_without_area_has_no_normal_but_a_place() -> None:
    line = _core.Meshes([np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])], [np.array([[0, 1, 2]], np.uint32)])
    distances, places, normals = _core.closest_points(line, [0], np.array([[1.5, 2.0, 0.0]]))
    assert distances[0] == pytest.approx(2.0)
    np.testing.assert_allclose(places[0], [1.5, 0, 0], atol=1e-12)
    np.testing.assert_array_equal(normals[0], 0.0)


@pytest.mark.parametrize(
    ("group", "points", "named"),
    [([], np.zeros((1, 3)), "group"), ([2], np.zeros((1, 3)), "group"), ([0], np.full((1, 3), np.nan), "points"),
     ([0], np.zeros((1, 2)), "points")],
)  # fmt: skip
def test_what_is_refused_is_named(group: list[int], points: np.ndarray, named: str) -> None:
    with pytest.raises(ValueError, match=rf"^{named}"):
        _core.closest_points(solids(0)[0], group, points)


@pytest.mark.parametrize(
    ("groups", "points", "named"),
    [([[0], []], np.zeros((2, 1, 3)), r"groups\[1\]"), ([[0], [2]], np.zeros((2, 1, 3)), r"groups\[1\]"),
     ([[0]], np.full((1, 1, 3), np.nan), "points"), ([[0]], np.zeros((1, 3)), "points"),
     ([[0]], np.zeros((2, 1, 3)), "points")],
)  # fmt: skip
def test_what_is_refused_of_groups_is_named(groups: list[list[int]], points: np.ndarray, named: str) -> None:
    with pytest.raises(ValueError, match=rf"^{named}"):
        _core.closest_points_of_groups(solids(0)[0], groups, points)
