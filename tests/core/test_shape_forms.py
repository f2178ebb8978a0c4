"""Forms of one object: flat, without names, in loose pieces."""

from __future__ import annotations

import numpy as np
from small_shapes import cabinet_shape

from kinmo.core.shape import Shape
from kinmo.core.shape_forms import FlatPart, flat_parts, flat_shape, in_pieces, without_names


def cabinet() -> Shape:
    return cabinet_shape(3)[0]


def area_by_body(parts: list[FlatPart]) -> dict[int | None, float]:
    areas: dict[int | None, float] = {}
    for part in parts:
        areas[part.body] = areas.get(part.body, 0.0) + float(part.mesh.face_areas.sum())
    return areas


def test_a_flat_shape_has_the_leaves_names_and_joints_of_the_shape() -> None:
    shape = cabinet()
    flat = flat_shape(shape, flat_parts(shape))
    assert [flat.parts[leaf].name for leaf in flat.leaves] == [shape.parts[leaf].name for leaf in shape.leaves]
    assert flat.mobility is not None and shape.mobility is not None
    for own, other in zip(flat.mobility.bodies, shape.mobility.bodies, strict=True):
        assert own.joint is other.joint
        assert [flat.leaves.index(leaf) for leaf in own.leaves] == [shape.leaves.index(leaf) for leaf in sorted(other.leaves)]


def test_parts_without_names_are_the_same_parts_in_another_order() -> None:
    parts = flat_parts(cabinet())
    nameless = without_names(parts, np.random.default_rng(0))
    assert sorted(part.name for part in nameless) == sorted(f"part_{i}" for i in range(len(parts)))
    assert {id(part.mesh) for part in nameless} == {id(part.mesh) for part in parts}
    assert area_by_body(nameless) == area_by_body(parts)


def test_loose_pieces_keep_the_surface_of_every_body() -> None:
    parts = flat_parts(cabinet())
    pieces = in_pieces(parts)
    assert all(piece.name == "" for piece in pieces)
    expected = area_by_body(parts)
    assert {body: round(area, 9) for body, area in area_by_body(pieces).items()} == {
        body: round(area, 9) for body, area in expected.items()
    }


def test_patches_of_a_loose_piece_have_a_node_of_their_own() -> None:
    shape = cabinet()
    pieces = in_pieces(flat_parts(shape))
    formed = flat_shape(shape, pieces)
    together: dict[int | None, int] = {}
    for piece in pieces:
        together[piece.piece] = together.get(piece.piece, 0) + 1
    inner = [len(part.children) for part in formed.parts[1:] if part.children]
    assert sorted(inner) == sorted(count for count in together.values() if count > 1)
    assert len(formed.leaves) == len(pieces)


def test_a_body_without_parts_is_left_out_and_its_riders_hang_on_the_body_below() -> None:
    shape = cabinet()
    assert shape.mobility is not None
    parts = flat_parts(shape)
    body = parts[-1].body
    flat = flat_shape(shape, [part for part in parts if part.body != body])
    assert flat.mobility is not None
    assert len(flat.mobility.bodies) == len(shape.mobility.bodies) - 1
    assert all(body.leaves for body in flat.mobility.bodies)
    assert sorted(leaf for body in flat.mobility.bodies for leaf in body.leaves) == list(flat.leaves)
