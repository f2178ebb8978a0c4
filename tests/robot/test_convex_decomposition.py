"""Convex pieces of parts."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from articulated import box_mesh
from scipy.spatial import ConvexHull

from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh, join
from kinmo.robot import convex_decomposition
from kinmo.robot.collision_shapes import CollisionShape, Hull
from kinmo.robot.convex_decomposition import convex_shapes
from kinmo.robot.convex_hulls import MAX_HULL_VERTICES, hull_of
from kinmo.robot.plane_cuts import MIN_THICKNESS


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(solid.vertices, float), np.asarray(solid.faces, np.uint32))


def points_of(shape: CollisionShape) -> np.ndarray:
    return shape.corners() if isinstance(shape, Box) else shape.mesh.vertices


def contains(shapes: list[CollisionShape], points: np.ndarray, slack: float) -> np.ndarray:
    """True for points in one of the shapes, or nearer to it than `slack`."""
    inside = np.zeros(len(points), bool)
    for shape in shapes:
        planes = ConvexHull(points_of(shape)).equations
        inside |= (points @ planes[:, :3].T + planes[:, 3] <= slack).all(axis=1)
    return inside


CHANNEL = trimesh.util.concatenate(
    [
        trimesh.creation.box(bounds=[[0, 0, 0], [1, 0.1, 1]]),
        trimesh.creation.box(bounds=[[0, 0.1, 0], [0.1, 0.8, 1]]),
        trimesh.creation.box(bounds=[[0.9, 0.1, 0], [1, 0.8, 1]]),
    ]
)
"""A bottom with two sides, whose surfaces touch without shared vertices."""
TORUS = trimesh.creation.torus(1.0, 0.2, major_sections=16, minor_sections=8)


def test_a_box_is_one_box() -> None:
    shapes, undivided = convex_shapes([box_mesh((0, 0, 0), (1, 2, 3))], 4.0)
    ((shape,),) = shapes
    assert isinstance(shape, Box)
    assert undivided == 0
    assert np.sort(shape.half_extents) == pytest.approx([0.5, 1.0, 1.5])


def test_each_loose_piece_has_its_own_shape() -> None:
    ((*shapes,),), _ = convex_shapes([join(box_mesh((0, 0, 0), (1, 1, 1)), box_mesh((2, 0, 0), (3, 1, 1)))], 4.0)
    assert sorted(float(shape.center[0]) for shape in shapes if isinstance(shape, Box)) == pytest.approx([0.5, 2.5])


def test_a_flat_part_gets_a_thickness() -> None:
    square = Mesh(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    ((shape,),), _ = convex_shapes([square], 2.0)
    assert isinstance(shape, Box)
    assert 2.0 * np.min(shape.half_extents) == pytest.approx(2.0 * MIN_THICKNESS)


def test_a_round_part_has_few_corners() -> None:
    ball = mesh_of(trimesh.creation.icosphere(4))
    ((shape,),), _ = convex_shapes([ball], 2.0)
    assert isinstance(shape, Hull)
    assert len(shape.mesh.vertices) <= MAX_HULL_VERTICES
    assert trimesh.Trimesh(shape.mesh.vertices, shape.mesh.faces).volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.2)


@pytest.mark.parametrize("has_coacd", [True, False])
def test_a_ring_keeps_its_hole(monkeypatch, has_coacd: bool) -> None:
    if has_coacd:
        pytest.importorskip("coacd")
    else:
        monkeypatch.setattr(convex_decomposition, "is_installed", lambda: False)
    (shapes,), undivided = convex_shapes([mesh_of(TORUS)], 3.0)
    assert len(shapes) > 2
    assert undivided == (0 if has_coacd else 1)
    assert not contains(shapes, np.zeros((1, 3)), 0.0).any()
    assert contains(shapes, np.asarray(TORUS.vertices), 0.05).mean() > 0.95


def test_parts_of_one_call_are_those_of_many_calls() -> None:
    parts = [box_mesh((0, 0, 0), (1, 1, 1)), mesh_of(CHANNEL), mesh_of(TORUS)]
    together, _ = convex_shapes(parts, 3.0)
    for part, shapes in zip(parts, together, strict=True):
        ((*alone,),), _ = convex_shapes([part], 3.0)
        assert [points_of(shape).tolist() for shape in alone] == [points_of(shape).tolist() for shape in shapes]


def test_hulls_face_outwards() -> None:
    hull = hull_of(np.random.default_rng(0).normal(size=(40, 3)), 0.0)
    solid = trimesh.Trimesh(hull.vertices, hull.faces, process=False)
    assert solid.is_watertight
    assert solid.volume > 0.0
