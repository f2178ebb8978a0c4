"""Sizes of boxes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kinmo.core.oriented_box import have_similar_size

SIZES = arrays(float, 3, elements=st.floats(0.01, 1.0))


@given(SIZES, st.permutations(range(3)))
def test_the_order_of_axes_does_not_change_the_size_of_a_box(half_extents: np.ndarray, order: list[int]) -> None:
    assert have_similar_size(half_extents, half_extents[order][None]).all()


@given(SIZES, SIZES)
def test_similar_size_is_symmetric(first: np.ndarray, second: np.ndarray) -> None:
    assert have_similar_size(first, second) == have_similar_size(second, first)


@given(SIZES, st.integers(0, 2))
def test_a_box_with_another_length_has_another_size(half_extents: np.ndarray, axis: int) -> None:
    longer = np.sort(half_extents)
    longer[axis:] *= 1.5
    assert not have_similar_size(half_extents, longer)
