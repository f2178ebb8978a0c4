"""Convex hulls, and the shapes they are written as."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from kinmo.core.oriented_box import Box
from kinmo.robot.collision_shapes import Cylinder, Hull
from kinmo.robot.convex_hulls import hull_of, simplest_shape, volume_of

TURN = Rotation.from_euler("xyz", [0.3, -0.8, 1.1]).as_matrix()


def turned(solid: trimesh.Trimesh) -> np.ndarray:
    return np.asarray(solid.vertices) @ TURN.T + [1.0, -2.0, 0.5]


@pytest.mark.parametrize(("sections", "is_round"), [(32, True), (16, True), (8, False), (6, False)])
@pytest.mark.parametrize("height", [0.02, 0.5, 3.0])
def test_prisms_with_many_sides_are_cylinders(sections: int, is_round: bool, height: float) -> None:
    points = turned(trimesh.creation.cylinder(0.25, height, sections=sections))
    shape = simplest_shape(hull_of(points, 0.0))
    assert isinstance(shape, Cylinder if is_round else Hull)
    if isinstance(shape, Cylinder):
        assert shape.radius == pytest.approx(0.25)
        assert 2.0 * shape.half_length == pytest.approx(height)
        assert abs(shape.axis @ TURN[:, 2]) == pytest.approx(1.0)
        assert shape.center == pytest.approx(np.array([1.0, -2.0, 0.5]))


def test_the_corners_of_a_cylinder_enclose_it() -> None:
    cylinder = Cylinder(np.array([1.0, 2, 3]), TURN[2], 0.5, 0.7)
    hull = ConvexHull(cylinder.corners())
    turns = np.linspace(0.0, 2.0 * np.pi, 100)
    ring = 0.5 * np.column_stack([np.cos(turns), np.sin(turns)]) @ cylinder.frame[:2]
    for end in (-0.7, 0.7):
        points = cylinder.center + ring + end * cylinder.axis
        assert (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max() < 1e-9
    assert cylinder.volume < hull.volume < 1.01 * cylinder.volume
    faces = np.abs(hull.equations[:, :3] @ cylinder.normals().T).max(axis=1)
    assert faces == pytest.approx(np.ones(len(faces)))


def test_a_cone_stays_a_hull() -> None:
    assert isinstance(simplest_shape(hull_of(turned(trimesh.creation.cone(0.5, 1.0)), 0.0)), Hull)


def test_only_an_equal_box_replaces_a_hull_exactly() -> None:
    box, prism = turned(trimesh.creation.box((1, 2, 3))), turned(trimesh.creation.cylinder(0.5, 1.0))
    assert isinstance(simplest_shape(hull_of(box, 0.0), is_exact=True), Box)
    assert isinstance(simplest_shape(hull_of(prism, 0.0), is_exact=True), Hull)


def test_the_volume_of_a_hull_is_known() -> None:
    assert volume_of(hull_of(turned(trimesh.creation.box((1, 2, 3))), 0.0)) == pytest.approx(6.0)
