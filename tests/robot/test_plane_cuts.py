"""Cuts of concave surfaces by planes."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from articulated import box_mesh
from scipy.spatial import ConvexHull

from kinmo.core.shape import Mesh, join
from kinmo.robot.plane_cuts import bisected, cut_at_faces, is_inside

BOARDS = [
    ((0, 0, 0), (2, 0.1, 1)),
    ((0, 0.1, 0), (0.1, 1, 1)),
    ((1.9, 0.1, 0), (2, 1, 1)),
    ((0.1, 0.1, 0), (1.9, 1, 0.1)),
]
"""A floor, two sides and a back."""


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(solid.vertices, float), np.asarray(solid.faces, np.uint32))


def volumes(pieces: list[np.ndarray] | None) -> list[float]:
    assert pieces is not None
    return [ConvexHull(piece).volume for piece in pieces]


def hollow_box() -> trimesh.Trimesh:
    """A closed box with thick walls and a closed room in it."""
    outer, inner = trimesh.creation.box((2, 1, 1)), trimesh.creation.box((1.8, 0.8, 0.8))
    inner.invert()
    return trimesh.util.concatenate([outer, inner])


def test_boards_are_taken_apart_exactly() -> None:
    pieces = cut_at_faces(join(*(box_mesh(*board) for board in BOARDS)), 2.5)
    expected = sum(float(np.prod(np.subtract(high, low))) for low, high in BOARDS)
    assert pieces is not None
    assert len(pieces) <= 5
    assert sum(volumes(pieces)) == pytest.approx(expected, rel=1e-6)


def test_an_l_is_two_boards() -> None:
    plan = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 4], [0, 4]], float)
    walls = [[a, (a + 1) % 6, (a + 1) % 6 + 6] for a in range(6)] + [[a, (a + 1) % 6 + 6, a + 6] for a in range(6)]
    floor = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    roof = [[a + 6, c + 6, b + 6] for a, b, c in floor]
    corners = np.concatenate([np.column_stack([plan, np.full(6, level)]) for level in (0.0, 1.0)])
    pieces = cut_at_faces(Mesh(corners, np.array(walls + floor + roof, np.uint32)), 5.0)
    assert sorted(volumes(pieces)) in ([pytest.approx(v) for v in pair] for pair in ([2.0, 4.0], [3.0, 3.0]))


@pytest.mark.parametrize("name", ["curved", "open", "two-sided sheet"])
def test_other_surfaces_are_not_taken_apart(name: str) -> None:
    box = join(*(box_mesh(*board) for board in BOARDS))
    surfaces = {
        "curved": mesh_of(trimesh.creation.torus(1.0, 0.2, major_sections=16, minor_sections=8)),
        "open": Mesh(box.vertices, box.faces[1:]),
        "two-sided sheet": join(Mesh(box.vertices, box.faces[:24]), Mesh(box.vertices, box.faces[:24, ::-1])),
    }
    assert cut_at_faces(surfaces[name], 2.5) is None


def test_halves_cover_what_was_bisected() -> None:
    ring = mesh_of(trimesh.creation.torus(1.0, 0.2, major_sections=16, minor_sections=8))
    pieces = bisected(ring, 3.0)
    covered = np.zeros(len(ring.vertices), bool)
    for hull in map(ConvexHull, pieces):
        covered |= (ring.vertices @ hull.equations[:, :3].T + hull.equations[:, 3] <= 1e-6).all(axis=1)
    assert covered.all()


def test_points_inside_a_solid_are_known() -> None:
    points = np.array([[0.95, 0, 0], [0, 0, 0], [0, 0.45, 0.2], [1.5, 0, 0]])
    assert is_inside(mesh_of(hollow_box()), points).tolist() == [True, False, True, False]
