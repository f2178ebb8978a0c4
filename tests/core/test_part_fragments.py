"""Random fragments of parts."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from small_shapes import area_by_body, cabinet_shape

from kinmo.core.part_fragments import PIECES, fragmented_parts
from kinmo.core.shape import bounds_of
from kinmo.core.shape_forms import flat_parts


@settings(max_examples=40)
@given(seed=st.integers(0, 2**31))
def test_every_body_keeps_nearly_all_of_its_surface(seed: int) -> None:
    parts = flat_parts(cabinet_shape(seed % 5)[0])
    before, after = area_by_body(parts), area_by_body(fragmented_parts(parts, np.random.default_rng(seed)))
    assert before.keys() == after.keys()
    assert all(0.7 * area <= after[body] for body, area in before.items())


@settings(max_examples=40)
@given(seed=st.integers(0, 2**31))
def test_fragments_are_whole_meshes_near_the_object(seed: int) -> None:
    parts = flat_parts(cabinet_shape(seed % 5)[0])
    low, high = bounds_of(part.mesh for part in parts)
    fragments = fragmented_parts(parts, np.random.default_rng(seed))
    assert len(fragments) <= max(len(parts), PIECES[1])
    for part in fragments:
        assert len(part.mesh.faces) and part.mesh.faces.max() < len(part.mesh.vertices)
        assert (part.mesh.vertices > low - 0.05 * (high - low).max()).all()
        assert (part.mesh.vertices < high + 0.05 * (high - low).max()).all()


def test_lists_break_into_few_or_many_fragments() -> None:
    parts = flat_parts(cabinet_shape(1)[0])
    counts = [len(fragmented_parts(parts, np.random.default_rng(seed))) for seed in range(40)]
    assert min(counts) < 2 * len(parts) < 6 * len(parts) < max(counts)


def test_the_same_seed_gives_the_same_fragments() -> None:
    parts = flat_parts(cabinet_shape(2)[0])
    first, second = (fragmented_parts(parts, np.random.default_rng(7)) for _ in range(2))
    assert len(first) == len(second)
    assert all(np.array_equal(one.mesh.vertices, other.mesh.vertices) for one, other in zip(first, second, strict=True))
