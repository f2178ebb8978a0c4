"""Boxes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from kinmo.core.box import are_alike

SIZES = arrays(float, 3, elements=st.floats(0.01, 1.0))


@given(SIZES, st.permutations(range(3)))
def test_a_box_is_as_large_as_itself_however_its_axes_are_named(half_extents: np.ndarray, order: list[int]) -> None:
    assert are_alike(half_extents, half_extents[order][None]).all()


@given(SIZES, SIZES)
def test_likeness_is_mutual(first: np.ndarray, second: np.ndarray) -> None:
    assert are_alike(first, second) == are_alike(second, first)


@given(SIZES, st.integers(0, 2))
def test_a_box_of_another_length_is_not_alike(half_extents: np.ndarray, axis: int) -> None:
    longer = np.sort(half_extents)
    longer[axis:] *= 1.5
    assert not are_alike(half_extents, longer)
