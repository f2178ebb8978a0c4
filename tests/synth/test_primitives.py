"""Primitives enclose the volume that they should, with normals that point outwards."""

from __future__ import annotations

from math import pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.core.shape import Mesh
from kinmo.synth.primitives import (
    arc_path,
    box,
    cylinder,
    ellipsoid,
    extrude,
    inside_out,
    join,
    lathe,
    mirror,
    move,
    open_box,
    rounded_box,
    rounded_outline,
    rounded_path,
    scale,
    sheet,
    sweep,
    torus,
    tube,
    turn,
)

sizes = st.floats(0.05, 3.0)
axes = st.sampled_from("xyz")


def volume(mesh: Mesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def polygon(segments: int) -> float:
    """Area of a regular polygon in the unit circle."""
    return 0.5 * segments * sin(2 * pi / segments)


@given(sizes, sizes, sizes, axes)
def test_boxes_enclose_their_volume(x: float, y: float, z: float, axis: str) -> None:
    assert volume(box((x, y, z), (1, 2, 3))) == pytest.approx(x * y * z)
    radius = 0.2 * min(x, y, z)
    rounded = rounded_box((x, y, z), radius, axis, corner_segments=16)
    length = {"x": x, "y": y, "z": z}[axis]
    assert volume(rounded) == pytest.approx(x * y * z - (4 - pi) * radius**2 * length, rel=1e-3)
    np.testing.assert_allclose(np.ptp(rounded.vertices, axis=0), (x, y, z))


@given(sizes, sizes, axes, st.integers(3, 40))
def test_round_solids_enclose_their_volume(radius: float, length: float, axis: str, segments: int) -> None:
    prism = polygon(segments) * radius**2 * length
    assert volume(cylinder(radius, length, axis, segments=segments)) == pytest.approx(prism)
    assert volume(tube(radius, radius / 2, length, axis, segments=segments)) == pytest.approx(0.75 * prism)
    assert volume(cylinder(radius, length, axis, segments=segments, top_radius=0.0)) == pytest.approx(prism / 3)
    assert np.ptp(cylinder(radius, length, axis).vertices, axis=0)["xyz".index(axis)] == pytest.approx(length)


def test_curved_solids_enclose_their_volume() -> None:
    assert volume(ellipsoid((1, 2, 3), segments=80, rings=60)) == pytest.approx(8 * pi, rel=5e-3)
    assert volume(torus(1.0, 0.2, "x", segments=90, rod_segments=40)) == pytest.approx(2 * pi**2 * 0.04, rel=1e-2)
    half_ring = sweep(arc_path((0, 0, 0), 1.0, 0, 180, "y", 90), 0.2, 40)
    assert volume(half_ring) == pytest.approx(pi**2 * 0.04, rel=1e-2)
    wedge = lathe(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), 20, arc=90.0)
    assert wedge.vertices[:, [0, 2]].min() > -1e-12, "a quarter turn from +z to +x"


@given(st.floats(-180, 180), st.floats(0.2, 3.0))
def test_transforms_keep_volume_and_outside(degrees: float, factor: float) -> None:
    mesh = rounded_box((1, 2, 0.5), 0.1)
    content = volume(mesh)
    assert volume(turn(mesh, (1, 2, 3), degrees, (0, 1, 0))) == pytest.approx(content)
    assert volume(mirror(mesh)) == pytest.approx(content)
    assert volume(scale(mesh, (1, factor, 1))) == pytest.approx(factor * content)
    assert volume(inside_out(mesh)) == pytest.approx(-content)
    assert volume(join(mesh, move(mesh, (3, 0, 0)))) == pytest.approx(2 * content)


def test_turning_is_right_handed() -> None:
    front = turn(Mesh(np.array([[1.0, 0.0, 0.0]]), np.zeros((0, 3), np.uint32)), (0, 1, 0), 90)
    np.testing.assert_allclose(front.vertices, [[0, 0, -1]], atol=1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_sheets_lie_across_their_axis(axis: str) -> None:
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    extent = np.ptp(sheet((1.5, 2.5), axis=axis).vertices, axis=0)
    assert extent[first] == 1.5 and extent[second] == 2.5 and extent["xyz".index(axis)] == 0.0
    prism = extrude(rounded_outline(1.5, 2.5, 0.1), 4.0, axis)
    assert np.ptp(prism.vertices, axis=0)[first] == pytest.approx(1.5)


def test_rounded_paths_keep_their_ends_and_cut_corners() -> None:
    path = rounded_path(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.0]]), 0.3)
    np.testing.assert_allclose(path[[0, -1]], [[0, 0, 0], [1, 1, 0]])
    assert np.linalg.norm(path - [1, 0, 0], axis=1).min() > 0.1


@given(sizes, sizes, sizes)
def test_an_open_box_encloses_its_walls(x: float, y: float, z: float) -> None:
    wall = 0.2 * min(x, y, z)
    shell = open_box((0, 0, 0), (x, y, z), wall)
    assert np.isclose(volume(shell), x * y * z - (x - 2 * wall) * (y - 2 * wall) * (z - wall))
    edges = np.sort(shell.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert np.all(np.unique(edges, axis=0, return_counts=True)[1] == 2)
