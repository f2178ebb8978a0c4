"""Groups of leaves of a prepared shape, and the sizes of its parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_shapes import cabinet

from kinmo.core.errors import InputError
from kinmo.features.prepared_shape import leaf_groups, part_sizes


def test_groups_are_distinct_parts_below_the_root_and_bodies() -> None:
    parts = [(0, 1, 2), (0, 1), (0,), (1,), (2,), (2,)]
    assert leaf_groups(parts, [(0, 1), (1, 2)]) == ((0, 1), (0,), (1,), (2,), (1, 2))
    assert leaf_groups(parts[:1], []) == ()


def test_every_distinct_part_has_one_size() -> None:
    shape = cabinet(0)
    groups = leaf_groups(shape.leaves_below, ())
    sizes = part_sizes(shape.leaves_below, shape.minimum_boxes)
    assert sizes.shape == (len(groups), 3)
    for group, size in zip(groups, sizes, strict=True):
        boxes = shape.minimum_boxes.half_extents[[i for i, below in enumerate(shape.leaves_below) if below == group]]
        assert any(np.array_equal(size, box) for box in boxes)


def test_a_shape_without_annotation_is_refused_where_one_is_needed() -> None:
    shape = cabinet(0)
    assert shape.annotation == (shape.mobility, shape.body_boxes)
    with pytest.raises(InputError, match="expected shape cabinet-0 to be annotated"):
        _ = replace(shape, mobility=None).annotation
