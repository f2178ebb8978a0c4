"""Symmetry-aligned boxes of any leaves of a prepared shape."""

from __future__ import annotations

import numpy as np
from small_shapes import cabinet, cabinet_shape

from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.symmetric_box import symmetric_box


def test_parts_and_bodies_have_their_stored_boxes() -> None:
    shape = cabinet(3)
    part = next(i for i, below in enumerate(shape.leaves_below) if len(below) == 2)
    np.testing.assert_array_equal(symmetric_box(shape, shape.leaves_below[part]).center, shape.symmetric_boxes.centers[part])
    for body, leaves in enumerate(shape.body_leaves):
        np.testing.assert_allclose(symmetric_box(shape, leaves).center, shape.body_boxes.centers[body])


def test_other_leaves_have_a_box_of_their_samples_or_meshes() -> None:
    shape = cabinet(3)
    mixed = [0, len(shape.leaves) - 1]
    fitted, exact = symmetric_box(shape, mixed), symmetric_box(shape, mixed, leaf_meshes(cabinet_shape(3)[0], shape))
    assert exact.volume * 0.7 < fitted.volume <= exact.volume * 1.001
