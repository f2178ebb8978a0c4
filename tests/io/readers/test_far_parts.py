"""Parts far from the object are found, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.shape import Mesh
from kinmo.io.readers.far_parts import far_parts
from kinmo.synth.primitives import box

CABINET = {0: box((1.0, 2.0, 0.5)), 1: box((0.02, 0.02, 0.02), (0.0, 0.0, 0.3)), 2: box((0.5, 2.0, 0.02), (0.0, 0.0, 0.26))}


def test_a_stray_box_is_far() -> None:
    assert far_parts({**CABINET, 3: box((0.1, 0.1, 0.1), (500.0, 0.0, 0.0))}) == [3]


def test_several_strays_in_different_places_are_far() -> None:
    strays = {3 + index: box((0.1, 0.1, 0.1), (900.0 * np.cos(index), 900.0 * np.sin(index), 0.0)) for index in range(4)}
    assert far_parts({**CABINET, **strays}) == list(strays)


@pytest.mark.parametrize("distance", [0.0, 3.0, 15.0])
def test_parts_of_a_scene_are_not_far(distance: float) -> None:
    assert far_parts({**CABINET, 3: box((0.1, 0.1, 0.1), (distance, 0.0, 0.0))}) == []


def test_small_parts_of_a_large_ring_are_not_far() -> None:
    beads: dict[int, Mesh] = {
        index: box((0.01, 0.01, 0.01), (np.cos(index / 20), np.sin(index / 20), 0.0)) for index in range(126)
    }
    assert far_parts(beads) == []


def test_one_part_is_left() -> None:
    assert len(far_parts({0: box((1, 1, 1)), 1: box((1, 1, 1), (1000, 0, 0))})) == 1
    assert far_parts({0: box((1, 1, 1))}) == []
