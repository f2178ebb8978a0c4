"""Random changes of a flat list of parts."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from small_shapes import area_by_body, cabinet_shape

from kinmo.core.part_changes import changed_parts
from kinmo.core.shape import bounds_of
from kinmo.core.shape_forms import flat_parts


@settings(max_examples=60)
@given(seed=st.integers(0, 2**31))
def test_every_body_keeps_nearly_all_of_its_surface(seed: int) -> None:
    parts = flat_parts(cabinet_shape(seed % 5)[0])
    changed = changed_parts(parts, np.random.default_rng(seed))
    before, after = area_by_body(parts), area_by_body(changed)
    assert before.keys() == after.keys()
    assert all(0.8 * area <= after[body] <= 1.5 * area for body, area in before.items())


@settings(max_examples=30)
@given(seed=st.integers(0, 2**31))
def test_changed_parts_are_whole_meshes_near_the_object(seed: int) -> None:
    parts = flat_parts(cabinet_shape(seed % 5)[0])
    changed = changed_parts(parts, np.random.default_rng(seed))
    low, high = bounds_of(part.mesh for part in parts)
    for part in changed:
        assert len(part.mesh.faces) and part.mesh.faces.max() < len(part.mesh.vertices)
        assert (part.mesh.face_areas > 0).any()
        assert (part.mesh.vertices > low - 0.05 * (high - low).max()).all()
        assert (part.mesh.vertices < high + 0.05 * (high - low).max()).all()


def test_all_kinds_of_changes_happen() -> None:
    parts = flat_parts(cabinet_shape(1)[0])
    counts = {len(changed_parts(parts, np.random.default_rng(seed))) for seed in range(40)}
    assert min(counts) < len(parts) < max(counts)


def test_the_same_seed_gives_the_same_parts() -> None:
    parts = flat_parts(cabinet_shape(2)[0])
    first, second = (changed_parts(parts, np.random.default_rng(7)) for _ in range(2))
    assert [part.name for part in first] == [part.name for part in second]
    assert all(np.array_equal(one.mesh.vertices, other.mesh.vertices) for one, other in zip(first, second, strict=True))
