"""The hash by which a changed shape is noticed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import articulated_shapes, shape_of_boxes
from hypothesis import given, settings

from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.core.shape_digest import shape_digest

BOXES = [((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (0.3, 2, 1))]


def shape() -> Shape:
    return shape_of_boxes(BOXES, (Body(0, "a", (1, 2)),))


def with_mesh(vertices: np.ndarray | None = None, faces: np.ndarray | None = None) -> Shape:
    part = shape().parts[2]
    assert part.mesh is not None
    mesh = replace(
        part.mesh,
        vertices=part.mesh.vertices if vertices is None else vertices,
        faces=part.mesh.faces if faces is None else faces,
    )
    return replace(shape(), parts=(*shape().parts[:2], replace(part, mesh=mesh)))


def changed(kind: str) -> Shape:
    part = shape().parts[2]
    if kind == "vertex":
        assert part.mesh is not None
        vertices = part.mesh.vertices.copy()
        vertices[0] += 0.001
        return with_mesh(vertices)
    if kind == "faces":
        assert part.mesh is not None
        return with_mesh(faces=part.mesh.faces[:, ::-1])
    other = {"name": replace(part, name="lid"), "id": replace(part, id=77)}[kind]
    return replace(shape(), parts=(*shape().parts[:2], other))


@pytest.mark.parametrize("kind", ["vertex", "faces", "name", "id"])
def test_any_change_of_parts_is_noticed(kind: str) -> None:
    assert shape_digest(changed(kind)) != shape_digest(shape())


def test_id_source_and_category_do_not_count() -> None:
    other = replace(shape(), id="other", source=Path("other"), category="Lamp", up=(0.0, 0.0, 1.0))
    assert shape_digest(other) == shape_digest(shape())


@settings(max_examples=30)
@given(articulated_shapes())
def test_rounding_errors_do_not_count(shape: Shape) -> None:
    parts = []
    for part in shape.parts:
        mesh = part.mesh
        moved = None if mesh is None else replace(mesh, vertices=mesh.vertices * (1.0 + 2e-16))
        parts.append(replace(part, mesh=moved))
    assert shape_digest(replace(shape, parts=tuple(parts))) == shape_digest(shape)
