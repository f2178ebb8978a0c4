"""`fit_symmetric_boxes` and `find_symmetries`: what known solids have, and nothing that is not there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from solids import (
    BOX,
    CYLINDER,
    DEGENERATE,
    F64,
    LINE,
    POINT,
    TETRAHEDRON,
    MeshArrays,
    arrays,
    clouds,
    meshes,
    moved,
    rotation,
    seeds,
)

from kinmo import _core

REFLECTION, ROTATION = 0, 1

# Tori, prisms and the like of which the symmetry planes of the minimum box, and the axis, are known.
HEXAGONAL_PRISM = arrays(trimesh.creation.cylinder(1.0, 1.2, sections=6))
WEDGE = (
    np.array([[0, 0, 0], [3, 0, 0], [0, 0, 1], [0, 2, 0], [3, 2, 0], [0, 2, 1]], float),
    np.array([[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2], [2, 5, 3], [2, 3, 0]], np.uint32),
)


@dataclass(frozen=True)
class Symmetries:
    """One part's symmetries."""

    kinds: np.ndarray
    orders: np.ndarray
    points: F64
    directions: F64
    errors: F64

    def of(self, kind: int, order: int) -> F64:
        return self.directions[(self.kinds == kind) & (self.orders == order)]


def symmetries_of(part: MeshArrays, seed: int = 0) -> Symmetries:
    group, *rest = _core.find_symmetries(meshes(part), seed=seed)
    assert (group == 0).all()
    return Symmetries(*rest)


def has_direction(directions: F64, expected: F64, degrees: float) -> bool:
    return bool((np.abs(directions @ expected) > np.cos(np.radians(degrees))).any())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("part", "planes"), [(BOX, 3), (CYLINDER, 3), (HEXAGONAL_PRISM, 3), (WEDGE, 1)], ids=["box", "cylinder", "prism", "wedge"]
)
def test_the_planes_of_known_solids_are_counted(part: MeshArrays, planes: int, seed: int) -> None:
    found = _core.fit_symmetric_boxes(meshes(moved(part, rotation(seed), 3.0, 0.7)), seed=seed)[3]
    assert found.tolist() == [planes]


def test_a_symmetric_box_is_preferred_to_a_smaller_one() -> None:
    # Along a thin rod's diagonal a lopsided box is smaller than the one that mirrors the cross of rods.
    rods = [trimesh.creation.box((4.0, 0.2, 0.2)), trimesh.creation.box((0.2, 2.0, 0.2))]
    cross = arrays(trimesh.util.concatenate(rods))
    smallest = _core.fit_boxes(meshes(cross))
    _, axes, half_extents, planes = _core.fit_symmetric_boxes(meshes(cross))
    assert planes.tolist() == [3]
    np.testing.assert_allclose(np.abs(axes[0]), np.eye(3), atol=1e-9)
    np.testing.assert_allclose(half_extents[0], [2.0, 1.0, 0.1])
    assert np.prod(half_extents) > 1.05 * np.prod(smallest[2])


@given(part=clouds(), seed=seeds)
@settings(max_examples=40)
def test_symmetric_boxes_are_no_smaller_than_the_smallest(part: MeshArrays, seed: int) -> None:
    volume = np.prod(_core.fit_boxes(meshes(part))[2])
    _, _, half_extents, planes = _core.fit_symmetric_boxes(meshes(part), seed=seed)
    assert np.prod(half_extents) >= volume * (1 - 2e-5)
    assert planes[0] <= 3


@pytest.mark.parametrize("seed", range(4))
def test_a_box_has_three_mirrors_and_three_half_turns(seed: int) -> None:
    turn = rotation(seed)
    found = symmetries_of(moved(BOX, turn, 5.0), seed)
    for kind in (REFLECTION, ROTATION):
        directions = found.of(kind, 2)
        assert len(directions) == 3
        np.testing.assert_allclose(np.sort(np.abs(directions @ turn), axis=1), np.tile([0, 0, 1], (3, 1)), atol=1e-6)
    np.testing.assert_allclose(found.points, 5.0, atol=1e-6)
    np.testing.assert_allclose(found.errors, 0.0, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_a_cylinder_turns_by_any_angle_about_its_axis(seed: int) -> None:
    turn = rotation(seed)
    found = symmetries_of(moved(CYLINDER, turn), seed)
    axes = found.of(ROTATION, 0)
    assert has_direction(axes, turn[:, 2], 0.5)
    assert has_direction(found.of(REFLECTION, 2), turn[:, 2], 0.5)
    assert not has_direction(axes, turn[:, 0], 45.0)


@pytest.mark.parametrize("seed", range(4))
def test_a_hexagonal_prism_turns_by_sixths(seed: int) -> None:
    turn = rotation(seed)
    assert has_direction(symmetries_of(moved(HEXAGONAL_PRISM, turn), seed).of(ROTATION, 6), turn[:, 2], 0.5)


@pytest.mark.parametrize("seed", range(6))
def test_the_axis_of_a_tilted_stem_with_an_arm_is_found(seed: int) -> None:
    """Neither box nor principal axes of such a part need lie along the axis that it turns about."""
    stem = trimesh.creation.cylinder(0.5, 4.0, sections=24)
    dome = trimesh.creation.icosphere(3, 0.8).apply_translation([0, 0, 2.0])
    arm = trimesh.creation.box((0.8, 0.15, 0.15)).apply_translation([1.1, 0, 1.0])
    part = arrays(trimesh.util.concatenate([stem, dome, arm]))
    turn = rotation(seed)
    found = symmetries_of(moved(part, turn, 2.0), seed)
    round_ones = (found.kinds == ROTATION) & (found.orders == 0)
    axis = turn[:, 2]
    assert has_direction(found.directions[round_ones], axis, 1.5)
    offsets = np.linalg.norm(np.cross(found.points[round_ones] - 2.0, axis), axis=1)
    assert offsets.min() < 0.02 * 5.0


def test_what_has_no_symmetry_gets_none() -> None:
    rng = np.random.default_rng(4)
    lump = trimesh.convex.convex_hull(rng.normal(size=(12, 3)) * [3.0, 2.0, 1.0])
    assert len(symmetries_of(arrays(lump)).kinds) == 0


def test_a_tetrahedron_has_mirrors_and_half_turns_but_no_right_angled_ones() -> None:
    found = symmetries_of(TETRAHEDRON)
    assert len(found.of(ROTATION, 2)) == 3
    assert 4 not in found.orders
    assert not has_direction(found.of(REFLECTION, 2), np.array([1.0, 0.0, 0.0]), 5.0)


@given(part=clouds(), seed=seeds)
@settings(max_examples=40)
def test_reported_symmetries_hold(part: MeshArrays, seed: int) -> None:
    found = symmetries_of(part, seed)
    diagonal = np.linalg.norm(np.ptp(part[0][part[1]].reshape(-1, 3), axis=0))
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=1), 1.0, atol=1e-9)
    assert (found.errors < 0.01).all()
    triangles = part[0][part[1]]
    samples = _core.sample_surface(meshes(part), 100, seed + 1)[0][0].astype(float)
    for kind, order, point, direction in zip(found.kinds, found.orders, found.points, found.directions, strict=True):
        if kind == REFLECTION:
            mapped = samples - 2 * np.outer((samples - point) @ direction, direction)
        else:
            angle = 2 * np.pi / order if order else 1.0
            mapped = trimesh.transform_points(samples, trimesh.transformations.rotation_matrix(angle, direction, point))
        distances = [
            np.linalg.norm(trimesh.triangles.closest_point(triangles, np.tile(p, (len(triangles), 1))) - p, axis=1).min()
            for p in mapped
        ]
        # Another sample of the surface than the one that was tested, hence the slack.
        assert np.quantile(distances, 0.7) < 0.02 * diagonal


@pytest.mark.parametrize("part", DEGENERATE.values(), ids=DEGENERATE)
@pytest.mark.parametrize(("shift", "scale"), [(0.0, 1.0), (1e6, 1.0), (0.0, 1e8), (0.0, 1e-8)])
def test_degenerate_far_huge_and_tiny_parts_have_finite_symmetries(part: MeshArrays, shift: float, scale: float) -> None:
    found = symmetries_of((part[0] * scale + shift, part[1]))
    for values in (found.points, found.directions, found.errors):
        assert np.isfinite(values).all()
    planes = _core.fit_symmetric_boxes(meshes((part[0] * scale + shift, part[1])))[3]
    assert planes[0] >= (1 if part is not DEGENERATE["non-manifold"] else 0)


def test_a_line_turns_about_itself() -> None:
    assert has_direction(symmetries_of(LINE).of(ROTATION, 0), np.array([1.0, 1.0, 2.0]) / np.sqrt(6.0), 0.1)


def test_a_point_has_no_symmetries_worth_naming() -> None:
    assert len(symmetries_of(POINT).kinds) == 0


def test_symmetries_of_a_group_are_those_of_its_union() -> None:
    other = moved(BOX, np.eye(3), np.array([0.0, 0.0, 3.0]))
    group, kinds, _, _, directions, _ = _core.find_symmetries(meshes(BOX, CYLINDER, other), [[1], [0, 2]])
    assert set(group.tolist()) == {0, 1}
    mirrors = directions[(group == 1) & (kinds == REFLECTION)]
    assert len(mirrors) == 3


@pytest.mark.parametrize("options", [{"samples": 0}, {"tolerance": 0.0}, {"tolerance": float("nan")}])
def test_options_that_make_no_sense_are_refused_by_name(options: dict[str, float]) -> None:
    for find in (_core.find_symmetries, _core.fit_symmetric_boxes, _core.find_round_pieces):
        with pytest.raises(ValueError, match=next(iter(options))):
            find(meshes(BOX), **options)  # type: ignore[operator]
