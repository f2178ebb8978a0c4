"""Triangles of polygons."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.polygons import triangulate

WHERE = Path("some.obj")
U_SHAPE = [(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]


def areas(points, sizes=None) -> tuple[float, float]:
    """Area that the triangles of polygons cover, and area of the polygons by the shoelace formula. `points` are [n, 2]."""
    flat = np.asarray(points, float)
    sizes = np.array([len(flat)] if sizes is None else sizes)
    turned = np.column_stack([flat, np.zeros(len(flat))]) @ Rotation.from_rotvec([0.4, -0.7, 0.2]).as_matrix().T
    faces, polygons = triangulate(turned, np.arange(len(flat)), sizes, WHERE)
    assert np.bincount(polygons, minlength=len(sizes)).tolist() == np.maximum(sizes - 2, 0).tolist()
    after = [np.roll(loop, -1, axis=0) for loop in np.split(flat, np.cumsum(sizes)[:-1])]
    x, y = flat.T
    shoelace = 0.5 * np.sum(x * np.concatenate(after)[:, 1] - y * np.concatenate(after)[:, 0])
    return float(Mesh(turned, faces.astype(np.uint32)).face_areas.sum()), abs(float(shoelace))


def test_convex_polygons_become_fans_around_their_first_corner():
    points = np.array([[0, 0, 0], [2, 0, 0], [3, 1, 0], [2, 2, 0], [0, 2, 0]], float)
    faces, polygons = triangulate(points, np.array([0, 1, 2, 3, 4, 1, 2, 3]), np.array([5, 3]), WHERE)
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4], [1, 2, 3]]
    assert polygons.tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("shift", range(8))
@pytest.mark.parametrize("step", [1, -1])
def test_the_notch_of_a_concave_polygon_stays_open(shift, step):
    covered, drawn = areas(np.roll(U_SHAPE, shift, axis=0)[::step])
    assert covered == pytest.approx(drawn) == 7.0


def test_concave_quads_are_split_at_their_inner_corner():
    quad = [(0, 0), (4, 0), (1, 1), (0, 4)]
    covered, drawn = areas(np.concatenate([np.roll(quad, shift, axis=0) for shift in range(4)]), [4] * 4)
    assert covered == pytest.approx(drawn) == 16.0


@given(st.lists(st.floats(0.1, 1.0), min_size=4, max_size=80))
def test_any_star_is_covered_exactly(radii):
    angles = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    covered, drawn = areas(np.array(radii)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]))
    assert covered == pytest.approx(drawn, rel=1e-9)


@pytest.mark.parametrize("corners", [20, 300])
def test_a_spiral_is_covered_exactly(corners):
    turn = np.linspace(0.0, 6.0 * np.pi, corners)
    ray = np.column_stack([np.cos(turn), np.sin(turn)])
    covered, drawn = areas(np.concatenate([(turn[:, None] + 3.0) * ray, ((turn[:, None] + 1.0) * ray)[::-1]]))
    assert covered == pytest.approx(drawn)


def test_a_hole_that_a_seam_connects_stays_open():
    outline = [(0, 0), (9, 0), (9, 9), (0, 9), (0, 0)]
    hole = [(3, 3), (3, 6), (6, 6), (6, 3), (3, 3)]
    covered, drawn = areas(outline + hole)
    assert covered == pytest.approx(drawn) == 72.0


@pytest.mark.parametrize("points", [np.zeros((5, 3)), np.full((5, 3), np.nan), np.eye(5, 3) * 1e300])
def test_polygons_without_area_or_with_wild_corners_give_triangles(points):
    assert len(triangulate(points, np.arange(5), np.array([5]), WHERE)[0]) == 3


def test_polygons_that_cross_themselves_end():
    points = np.random.default_rng(0).random((500, 3))
    faces, _ = triangulate(points, np.arange(500), np.array([500]), WHERE)
    assert len(faces) == 498


def test_a_concave_polygon_of_too_many_corners_is_an_error():
    turn = np.linspace(0.0, 6.0 * np.pi, 20_000)
    ray = np.column_stack([np.cos(turn), np.sin(turn)])
    with pytest.raises(InputError, match="triangulate its meshes"):
        areas(np.concatenate([(turn[:, None] + 3.0) * ray, ((turn[:, None] + 1.0) * ray)[::-1]]))
