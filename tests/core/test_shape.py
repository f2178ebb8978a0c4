"""Meshes and part hierarchies."""

from __future__ import annotations

import numpy as np
from articulated import box_mesh, shape_of_boxes

from kinmo.core.mobility import Body
from kinmo.core.shape import Mesh, Part, Shape, bounds_of, join

SQUARE = Mesh(np.array([[0.0, 0, 0], [9, 9, 9], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 2, 3], [0, 3, 4]], np.uint32))
"""A square with one vertex that no face uses."""


def test_unused_vertices_do_not_count() -> None:
    assert len(SQUARE.corners) == 4
    assert np.array_equal(SQUARE.compact.triangles, SQUARE.triangles)
    assert len(SQUARE.compact.vertices) == 4
    low, high = bounds_of([SQUARE])
    assert (low.tolist(), high.tolist()) == ([0, 0, 0], [1, 1, 0])


def test_joined_meshes_keep_all_triangles() -> None:
    box = box_mesh((2, 0, 0), (3, 1, 1))
    joined = join(SQUARE, box)
    assert np.array_equal(joined.triangles, np.concatenate([SQUARE.triangles, box.triangles]))
    assert not len(join().faces)


def test_leaves_below_a_part_are_those_of_its_subtree() -> None:
    parts = (Part(0, "root", None, (1, 4)), Part(1, "a", 0, (2, 3)), Part(2, "b", 1), Part(3, "c", 1), Part(4, "d", 0))
    shape = Shape("x", "Box", parts, source=None, layout="test")  # type: ignore[arg-type]
    assert shape.leaves == (2, 3, 4)
    assert shape.leaves_below == ((2, 3, 4), (2, 3), (2,), (3,), (4,))


def test_center_and_diagonal_are_those_of_the_bounding_box() -> None:
    shape = shape_of_boxes([((0, 0, 0), (1, 1, 1)), ((1, 1, 1), (2, 3, 5))], (Body(0, "a", (1, 2)),))
    assert shape.center.tolist() == [1.0, 1.5, 2.5]
    assert shape.diagonal == np.sqrt(4 + 9 + 25)
