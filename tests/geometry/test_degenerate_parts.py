"""Degenerate, far, huge and tiny parts through every function that looks at two of them: finite and right."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from brute_force import triangle_soup_distance
from solids import DEGENERATE, F64, MeshArrays, meshes

from kinmo import _core

PAIRS = list(itertools.combinations_with_replacement(DEGENERATE, 2))
PLACES = [(0.0, 1.0), (1e6, 1.0), (0.0, 1e-9), (0.0, 1e9), (1e6, 1e-9), (1e6, 1e9)]
GAP = np.array([4.0, 0.5, -0.25])


def placed(part: MeshArrays, offset: float, scale: float) -> MeshArrays:
    """`part` moved by `offset` and then scaled."""
    return (part[0] + offset) * scale, part[1]


def pair(names: tuple[str, str], offset: float, scale: float) -> list[MeshArrays]:
    """Two degenerate parts, the second moved away."""
    first, second = (DEGENERATE[name] for name in names)
    return [placed(first, offset, scale), placed((second[0] + GAP, second[1]), offset, scale)]


def triangles(part: MeshArrays) -> F64:
    """The triangles [F, 3, 3] of a part, each once."""
    return np.unique(part[0][part[1]], axis=0)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_distances_are_those_of_all_pairs_of_triangles(names: tuple[str, str]) -> None:
    first, second = pair(names, 0.0, 1.0)
    expected = triangle_soup_distance(triangles(first), triangles(second))
    for offset, scale in PLACES:
        _, distances, near, far = _core.part_distances(meshes(*pair(names, offset, scale)))
        assert distances[0] / scale == pytest.approx(expected, abs=1e-9)
        np.testing.assert_allclose(np.linalg.norm(far - near, axis=1) / scale, distances / scale, atol=1e-9)


@pytest.mark.parametrize("name", DEGENERATE)
def test_a_part_touches_itself(name: str) -> None:
    for offset, scale in PLACES:
        part = placed(DEGENERATE[name], offset, scale)
        assert _core.part_distances(meshes(part, part))[1].tolist() == [0.0]


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_nearest_places_are_as_far_as_triangles_are(names: tuple[str, str]) -> None:
    corners = pair(names, 0.0, 1.0)[0][0][:3]
    there = triangles(pair(names, 0.0, 1.0)[1])
    expected = [triangle_soup_distance(np.tile(corner, (1, 3, 1)), there) for corner in corners]
    for offset, scale in PLACES:
        first, second = pair(names, offset, scale)
        distances, places, normals = _core.closest_points(meshes(second), [0], first[0][:3])
        np.testing.assert_allclose(distances / scale, expected, atol=1e-8)
        assert np.isfinite(places).all()
        lengths = np.linalg.norm(normals, axis=1)
        assert (np.isclose(lengths, 1) | (lengths == 0)).all()


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_interaction_regions_lie_within_the_parts(names: tuple[str, str]) -> None:
    for offset, scale in PLACES:
        parts = pair(names, offset, scale)
        points = _core.sample_surface(meshes(*parts), 60)[0].astype(float)
        region = _core.interaction_regions(points, np.array([[0, 1], [1, 0]], np.uint32))
        slack = 1e-6 * (scale + np.abs(points).max())
        low, high = points.min(axis=(0, 1)) - slack, points.max(axis=(0, 1)) + slack
        assert ((region.centroids >= low) & (region.centroids <= high)).all()
        assert (np.isfinite(region.weights) & (region.weights > 0)).all()
        assert region.offsets[-1] == len(region.weights)


@pytest.mark.parametrize("names", PAIRS, ids="-".join)
def test_travels_stay_within_their_limits_and_scale(names: tuple[str, str]) -> None:
    kinds = np.array([0, 1, 2], np.uint8)
    directions, pivots = np.eye(3)[[1, 0, 2]], np.array([[2.0, 0, 0], [0, 0, 0], [4, 1, 0]])
    for offset, scale in PLACES:
        unit = np.array([1.0, scale, 1.0])
        lower, upper, penetration = _core.sweep(
            meshes(*pair(names, offset, scale)), [0], [1], kinds, directions, (pivots + offset) * scale, -3 * unit, 3 * unit
        )
        assert ((-3 * unit <= lower) & (lower <= 0) & (upper >= 0) & (upper <= 3 * unit)).all()
        assert ((penetration >= 0) & (penetration <= 1)).all()
        # Away from the other part the slide is free.
        assert lower[1] == -3 * unit[1]


@pytest.mark.parametrize("name", DEGENERATE)
@pytest.mark.parametrize(("offset", "scale"), PLACES)
def test_boxes_and_symmetries_are_finite_and_extend_as_the_part_does(name: str, offset: float, scale: float) -> None:
    part = placed(DEGENERATE[name], offset, scale)
    extent = np.ptp(part[0], axis=0).max()
    for fit in (
        _core.fit_boxes,
        lambda parts: _core.fit_symmetric_boxes(parts)[:3],
        lambda parts: _core.fit_aligned_boxes(parts, np.eye(3)),
    ):
        centers, axes, half_extents = fit(meshes(part))
        assert np.isfinite(centers).all()
        np.testing.assert_allclose(axes[0] @ axes[0].T, np.eye(3), atol=1e-9)
        assert 2 * half_extents.max() >= 0.8 * extent
    errors = _core.find_symmetries(meshes(part))[5]
    assert ((errors >= 0) & (errors < 0.01)).all()


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_boxes_without_thickness_overlap_in_nothing(size: float) -> None:
    flat = np.zeros((1, 3)), np.eye(3)[None], np.array([[1.0, 1.0, 0.0]]) * size
    full = np.zeros((1, 3)), np.eye(3)[None], np.ones((1, 3)) * size
    assert _core.box_iou(*flat, *full).tolist() == [0.0]
    assert _core.box_iou(*full, *full) == pytest.approx([1.0])
