"""Shapes written in the format of PartNet-Mobility come back unchanged through its reader."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from articulated import articulated_shapes
from exports import write_partnet_mobility
from hypothesis import given, settings

from kinmo.core.categories import canonical_category
from kinmo.core.joint import Joint
from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.core.vector import distance_to_line
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY, read_partnet_mobility


def round_trip(shape: Shape) -> Shape:
    assert shape.mobility is not None
    with tempfile.TemporaryDirectory() as root:
        folder = write_partnet_mobility(shape, shape.mobility, Path(root) / shape.id)
        assert [found.layout for found in discover(Path(root))] == [PARTNET_MOBILITY]
        return read_partnet_mobility(folder)


def assert_same_joint(found: Joint, expected: Joint) -> None:
    assert found.kind is expected.kind
    np.testing.assert_allclose(found.direction, expected.direction, atol=1e-9)
    if expected.has_pivot:
        np.testing.assert_allclose(distance_to_line(found.pivot[None], expected.pivot, expected.direction), 0.0, atol=1e-9)
    if expected.lower is None or expected.upper is None:
        assert not found.is_limited
    elif expected.lower <= 0.0 <= expected.upper:
        np.testing.assert_allclose([found.lower, found.upper], [expected.lower, expected.upper], atol=1e-9)


@settings(max_examples=60)
@given(articulated_shapes())
def test_bodies_joints_and_meshes_survive_a_round_trip(shape: Shape) -> None:
    found = round_trip(shape)
    assert (found.category, found.id) == (canonical_category(shape.category), shape.id)
    assert [(p.id, p.name, p.parent, p.children) for p in found.parts] == [
        (p.id, p.name, p.parent, p.children) for p in shape.parts
    ]
    for one, other in zip(found.meshes(), shape.meshes(), strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.faces, other.faces)
    assert found.mobility is not None and shape.mobility is not None

    def key(body: Body) -> tuple[int, ...]:
        return body.leaves

    pairs = list(zip(sorted(found.mobility.bodies, key=key), sorted(shape.mobility.bodies, key=key), strict=True))
    for body, expected in pairs:
        assert (body.leaves, body.parent is None, body.joint is None) == (
            expected.leaves,
            expected.parent is None,
            expected.joint is None,
        )
        if body.parent is not None and expected.parent is not None:
            assert found.mobility.bodies[body.parent].leaves == shape.mobility.bodies[expected.parent].leaves
        if body.joint is not None and expected.joint is not None:
            assert_same_joint(body.joint, expected.joint)


@settings(max_examples=20)
@given(articulated_shapes(max_bodies=3))
def test_writing_twice_gives_the_same_bytes(shape: Shape) -> None:
    assert shape.mobility is not None
    with tempfile.TemporaryDirectory() as root:
        folders = [write_partnet_mobility(shape, shape.mobility, Path(root) / name) for name in ("a", "b")]
        texts = [{p.relative_to(f): p.read_bytes() for p in f.rglob("*") if p.is_file()} for f in folders]
        assert texts[0] == texts[1]
