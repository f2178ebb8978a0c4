"""Free travel of a part along a joint."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from brute_force import block, meshes_of

from kinmo import _core

REVOLUTE, PRISMATIC = 0, 1
TOLERANCE = 0.01
WALL = 0.05


def sweep(
    meshes: _core.Meshes, joints: list[tuple[int, tuple[float, ...], tuple[float, ...]]], reach: float, moving: int = 1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    kinds, directions, pivots = zip(*joints, strict=True)
    limits = np.full(len(joints), reach)
    members = list(range(len(meshes)))
    lines = np.array(directions, float), np.array(pivots, float)
    return _core.sweep(meshes, members[:moving], members[moving:], np.array(kinds, np.uint8), *lines, -limits, limits)


def cabinet(gap: float = 0.0) -> list[trimesh.Trimesh]:
    """A drawer 1 x 0.3 x 1 in a box that is open towards +z; `gap` is left all around (negative: the two overlap)."""
    side, top = 0.5 + gap + WALL / 2, 0.15 + gap + WALL / 2
    return [
        block((1, 0.3, 1), (0, 0, 0)),
        block((1.1, WALL, 1), (0, top, 0)),
        block((1.1, WALL, 1), (0, -top, 0)),
        block((WALL, 0.3, 1), (side, 0, 0)),
        block((WALL, 0.3, 1), (-side, 0, 0)),
        block((1.1, 0.4, WALL), (0, 0, -0.5 - gap - WALL / 2)),
    ]


@pytest.mark.parametrize("gap", [0.0, 0.01, -0.005])
def test_a_drawer_opens_and_meets_its_back_and_walls(gap: float) -> None:
    solids = cabinet(gap)
    joints = [(PRISMATIC, axis, (0, 0, 0)) for axis in ((0, 0, 1), (1, 0, 0), (0, 1, 0))]
    lower, upper, penetration = sweep(meshes_of(*solids), joints, 0.8)
    diagonal = np.linalg.norm(solids[0].extents)
    slack = 1.5 * TOLERANCE * diagonal + max(gap, 0)
    assert upper[0] == 0.8
    assert penetration[0, 1] == 0
    assert -slack <= lower[0] <= 0
    assert (np.abs(np.concatenate([lower[1:], upper[1:]])) <= slack).all()
    assert (penetration[0, 0] > 0.5) and (penetration[1:] > 0.5).all()


def test_a_door_turns_until_its_stop() -> None:
    door = block((1, 2, 0.04), (0.5, 0, 0))
    frame = block((0.1, 2, 0.1), (-0.05, 0, 0))
    angle = 1.1
    # A wall through the hinge line, whose face is a plane at `angle` from the closed door.
    wall = block((0.5, 2, 0.04), (0.65, 0, 0))
    wall.apply_transform(trimesh.transformations.rotation_matrix(angle, (0, 1, 0)))
    lower, upper, penetration = sweep(meshes_of(door, frame, wall), [(REVOLUTE, (0, 1, 0), (0, 0, 0))], 1.5)
    assert lower[0] == -1.5
    assert penetration[0, 0] == 0
    # Both leaves are 0.04 thick, and meet where they are nearest to the hinge: at a radius of 0.4.
    assert upper[0] == pytest.approx(angle - 2 * np.arcsin(0.02 / 0.4), abs=0.06)
    assert penetration[0, 1] > 0.1


def test_a_small_stop_counts() -> None:
    door, stop = block((1, 2, 0.04), (0.5, 0, 0)), block((0.05, 0.05, 0.05), (0.95, 0, -0.2))
    _, upper, _ = sweep(meshes_of(door, stop), [(REVOLUTE, (0, 1, 0), (0, 0, 0))], np.pi / 2)
    assert 0.1 < upper[0] < 0.3


def test_a_lid_without_thickness_stops_at_a_wall() -> None:
    lid = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]])
    wall = trimesh.Trimesh([[0.2, 0.4, 0], [0.9, 0.4, 0], [0.9, 0.4, 1], [0.2, 0.4, 1]], [[0, 1, 2], [0, 2, 3]])
    lower, upper, _ = sweep(meshes_of(lid, wall), [(PRISMATIC, (0, 1, 0), (0, 0, 0))], 1.0)
    assert lower[0] == -1.0
    assert upper[0] == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize("gap", [0.05, 0.19, 0.21, 0.4])
def test_how_far_it_is_to_a_wall_does_not_depend_on_how_far_it_may_go(gap: float) -> None:
    lid = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]], [[0, 1, 2], [0, 2, 3]])
    wall = trimesh.Trimesh([[0.2, gap, 0], [0.9, gap, 0], [0.9, gap, 1], [0.2, gap, 1]], [[0, 1, 2], [0, 2, 3]])
    for reach in (gap + 0.01, 0.5, 1.0, 3.0):
        _, upper, _ = sweep(meshes_of(lid, wall), [(PRISMATIC, (0, 1, 0), (0, 0, 0))], reach)
        assert upper[0] == pytest.approx(gap, abs=1e-9)


@pytest.mark.parametrize("angle", [0.05, 0.14, 0.3])
def test_a_door_without_thickness_stops_at_a_wall_that_is_near(angle: float) -> None:
    door = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], float)
    wall = trimesh.transform_points(door[[0, 1, 2, 3]], trimesh.transformations.rotation_matrix(-angle, (0, 1, 0)))
    faces = [[0, 1, 2], [0, 2, 3]]
    solids = meshes_of(trimesh.Trimesh(door, faces), trimesh.Trimesh(wall, faces))
    lower, upper, _ = sweep(solids, [(REVOLUTE, (0, -1, 0), (0, 0, 0))], np.pi)
    assert upper[0] == pytest.approx(angle, abs=0.02)
    assert lower[0] == -np.pi


def twice(solid: trimesh.Trimesh) -> trimesh.Trimesh:
    """Mesh with every face there for either side, as in most meshes of PartNet-Mobility."""
    return trimesh.Trimesh(solid.vertices, np.concatenate([solid.faces, solid.faces[:, ::-1]]), process=False)


def test_faces_that_are_there_twice_change_nothing() -> None:
    bar, box = block((0.2, 0.2, 2), (0, 0, 0)), block((1, 1, 0.5), (0, 0, 0))
    pulled = (PRISMATIC, (0, 0, 1), (0, 0, 0))
    for solids, joints in (([bar, box], [pulled]), (cabinet(), [pulled, (PRISMATIC, (1, 0, 0), (0, 0, 0))])):
        once = sweep(meshes_of(*solids), joints, 0.5)
        both = sweep(meshes_of(*map(twice, solids)), joints, 0.5)
        for known, found in zip(once, both, strict=True):
            np.testing.assert_allclose(found, known, atol=0.05)


@pytest.mark.parametrize("side", [-1, 1])
def test_what_slides_in_the_plane_of_a_side_of_a_wall_meets_it(side: int) -> None:
    lid = trimesh.Trimesh([[0, 1, 0], [0.1, 1, 0], [0.1, 1, 1], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]])
    wall = block((0.02, 1, 1), (0.56, 1 + 0.5 * side, 0.5))
    _, upper, _ = sweep(meshes_of(lid, wall), [(PRISMATIC, (1, 0, 0), (0, 0, 0))], 1.0)
    assert upper[0] == pytest.approx(0.45, abs=0.01)


@pytest.mark.parametrize("scale", [1e-8, 1e8])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_travel_scales_with_the_shape_and_moves_with_it(scale: float, offset: float) -> None:
    solids = cabinet(0.02)
    joints = [(PRISMATIC, (0, 0, 1), (0, 0, 0)), (REVOLUTE, (0, 1, 0), (0.5, 0, 0.5)), (REVOLUTE, (1, 0, 0), (0, 0.15, 0.5))]
    expected = sweep(meshes_of(*solids), joints, 0.5)
    for solid in solids:
        solid.apply_translation([offset] * 3)
        solid.apply_scale(scale)
    kinds, directions, pivots = zip(*joints, strict=True)
    unit = np.array([scale, 1, 1])
    lower, upper, penetration = _core.sweep(
        meshes_of(*solids),
        [0],
        [1, 2, 3, 4, 5],
        np.array(kinds, np.uint8),
        np.array(directions, float),
        (np.array(pivots, float) + offset) * scale,
        -0.5 * unit,
        0.5 * unit,
    )
    tight = 1e-6 if offset else 1e-9
    np.testing.assert_allclose(lower / unit, expected[0], atol=tight)
    np.testing.assert_allclose(upper / unit, expected[1], atol=tight)
    np.testing.assert_allclose(penetration, expected[2], atol=0.01)


def test_degenerate_parts_travel_without_failing() -> None:
    point = trimesh.Trimesh(np.ones((3, 3)), [[0, 1, 2]], process=False)
    needle = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
    triangle = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], process=False)
    joints = [(REVOLUTE, (0, 1, 0), (0, 0, 0)), (PRISMATIC, (1, 0, 0), (0, 0, 0)), (2, (0, 0, 1), (0, 0, 0))]
    for first in (point, needle, triangle):
        for second in (point, needle, triangle):
            lower, upper, penetration = sweep(meshes_of(first, second), joints, 1.0)
            assert ((lower >= -1) & (lower <= 0) & (upper >= 0) & (upper <= 1)).all()
            assert ((penetration >= 0) & (penetration <= 1)).all()


def test_arguments_are_refused_by_name() -> None:
    meshes = meshes_of(*cabinet())
    joint = np.zeros(1, np.uint8), np.eye(3)[:1], np.zeros((1, 3))
    zero, one = np.zeros(1), np.ones(1)
    with pytest.raises(ValueError, match=r"^moving: empty"):
        _core.sweep(meshes, [], [1], *joint, zero, one)
    with pytest.raises(ValueError, match=r"^obstacles: index 9 is outside 0\.\.6"):
        _core.sweep(meshes, [0], [9], *joint, zero, one)
    with pytest.raises(ValueError, match=r"^obstacles: mesh 0 is in moving too"):
        _core.sweep(meshes, [0], [0], *joint, zero, one)
    with pytest.raises(ValueError, match=r"^lower: row 0 is above 0"):
        _core.sweep(meshes, [0], [1], *joint, one, one)
    with pytest.raises(ValueError, match=r"^upper: shape"):
        _core.sweep(meshes, [0], [1], *joint, zero, np.ones(2))
    with pytest.raises(ValueError, match=r"^tolerance"):
        _core.sweep(meshes, [0], [1], *joint, zero, one, tolerance=-0.1)
    with pytest.raises(ValueError, match=r"^steps"):
        _core.sweep(meshes, [0], [1], *joint, zero, one, steps=0)
