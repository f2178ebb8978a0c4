"""The annotation of a prepared shape."""

from __future__ import annotations

from dataclasses import replace

import pytest
from small_shapes import cabinet

from kinmo.core.errors import InputError


def test_a_shape_without_annotation_is_refused_where_one_is_needed() -> None:
    shape = cabinet(0)
    assert shape.annotation == (shape.mobility, shape.body_boxes)
    with pytest.raises(InputError, match="expected shape cabinet-0 to be annotated"):
        _ = replace(shape, mobility=None).annotation
