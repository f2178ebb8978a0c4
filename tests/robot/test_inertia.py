"""Mass and inertia of links."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from articulated import box_mesh
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.shape import Mesh, join
from kinmo.robot.inertia import MIN_MASS, inertial_of, is_solid


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.asarray(solid.vertices, float), np.asarray(solid.faces, np.uint32))


def placed(solid: trimesh.Trimesh, seed: int) -> trimesh.Trimesh:
    """A solid, turned and moved at random."""
    rng = np.random.default_rng(seed)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.random(random_state=seed).as_matrix(), rng.uniform(-3.0, 3.0, 3)
    return solid.copy().apply_transform(pose)


def moments(inertia: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.sort(np.linalg.eigvalsh(inertia))


@given(st.integers(0, 1000))
def test_closed_parts_agree_with_trimesh(seed: int) -> None:
    solid = placed(trimesh.creation.annulus(0.3, 0.5, 0.2), seed)
    solid.density = 250.0
    found = inertial_of([mesh_of(solid)], [250.0])
    assert found.mass == pytest.approx(solid.mass)
    assert found.center == pytest.approx(solid.center_mass, abs=1e-9)
    assert found.inertia == pytest.approx(solid.moment_inertia, abs=1e-8)


@pytest.mark.parametrize("offset", [(5e5, 4.6e6, 100.0), (1e8, 0.0, -1e8)], ids=["UTM", "farther"])
def test_parts_far_from_the_origin_have_the_inertia_of_near_ones(offset: tuple[float, float, float]) -> None:
    near = mesh_of(trimesh.creation.annulus(0.05, 0.15, 0.1))
    far = Mesh(near.vertices + offset, near.faces)
    found, expected = inertial_of([far]), inertial_of([near])
    assert is_solid(far)
    assert found.mass == pytest.approx(expected.mass, rel=1e-6)
    assert found.center == pytest.approx(expected.center + offset, abs=1e-6)
    assert found.inertia == pytest.approx(expected.inertia, rel=1e-6, abs=1e-9)


def test_vertices_without_a_face_do_not_change_the_inertia() -> None:
    near = mesh_of(trimesh.creation.annulus(0.05, 0.15, 0.1))
    stray = Mesh(np.concatenate([[[-1e7, 0.0, 0.0]], near.vertices]), near.faces + np.uint32(1))
    assert inertial_of([stray]).inertia == pytest.approx(inertial_of([near]).inertia, abs=1e-9)


@given(st.integers(0, 1000))
def test_open_parts_weigh_as_much_as_their_box(seed: int) -> None:
    solid = placed(trimesh.creation.box((0.2, 0.5, 1.0)), seed)
    closed = inertial_of([mesh_of(solid)])
    opened = Mesh(mesh_of(solid).vertices, mesh_of(solid).faces[2:])
    assert not is_solid(opened)
    found = inertial_of([opened])
    assert found.mass == pytest.approx(closed.mass)
    assert found.inertia == pytest.approx(closed.inertia, abs=1e-6)


def test_a_surface_that_faces_inwards_is_no_solid() -> None:
    box = mesh_of(trimesh.creation.box((1.0, 1.0, 1.0)))
    assert is_solid(box)
    assert not is_solid(Mesh(box.vertices, box.faces[:, ::-1]))


@given(st.integers(0, 1000), st.integers(0, 1000))
def test_two_parts_weigh_as_one_of_both(one: int, other: int) -> None:
    assume(one != other)
    solids = [placed(trimesh.creation.icosphere(1, 0.3), seed) for seed in (one, other)]
    apart = inertial_of([mesh_of(solid) for solid in solids])
    together = inertial_of([mesh_of(trimesh.util.concatenate(solids))])
    assert apart.mass == pytest.approx(together.mass)
    assert apart.center == pytest.approx(together.center, abs=1e-9)
    assert apart.inertia == pytest.approx(together.inertia, abs=1e-6)


@pytest.mark.parametrize("size", [(1e-5, 1e-5, 1e-5), (0.0, 1.0, 1.0), (0.5, 0.4, 0.3)])
def test_inertia_is_physically_possible(size: tuple[float, float, float]) -> None:
    box = mesh_of(trimesh.creation.box((1.0, 1.0, 1.0)))
    found = inertial_of([Mesh(box.vertices * size, box.faces)])
    least, middle, most = moments(found.inertia)
    assert found.mass >= MIN_MASS
    assert least > 0.0
    assert most <= least + middle + 1e-12


@pytest.mark.parametrize("gap", [0.0, 1e-9, 2e-5])
def test_a_surface_with_two_sides_has_the_mass_of_its_box(gap: float) -> None:
    sphere = trimesh.creation.icosphere(2, 0.3)
    vertices = np.concatenate([sphere.vertices, sphere.vertices * (1.0 - gap / 0.3)])
    both = Mesh(vertices, np.concatenate([sphere.faces, sphere.faces[:, ::-1] + len(sphere.vertices)]))
    assert not is_solid(both)
    assert inertial_of([both]).mass == pytest.approx(inertial_of([Mesh(vertices, sphere.faces[1:])]).mass, rel=1e-3)


def test_a_closed_mesh_without_area_is_no_solid() -> None:
    tetrahedron = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], np.uint32)
    assert not is_solid(Mesh(np.zeros((4, 3)), tetrahedron))


def test_a_link_without_parts_is_a_tiny_ball() -> None:
    found = inertial_of([])
    assert found.mass == MIN_MASS
    assert found.inertia == pytest.approx(found.inertia[0, 0] * np.eye(3))


def test_boards_that_share_edges_have_the_mass_of_their_volume() -> None:
    boards = [((0, 0, 0), (1, 0.1, 1)), ((0, 0.1, 0), (0.1, 1, 1)), ((0.9, 0.1, 0), (1, 1, 1))]
    floor = [((0, 0, 0), (0.1, 0.1, 1)), ((0.1, 0, 0), (0.9, 0.1, 1)), ((0.9, 0, 0), (1, 0.1, 1))]
    volume = sum(float(np.prod(np.subtract(high, low))) for low, high in boards)
    found = inertial_of([join(*(box_mesh(*board) for board in (*floor, *boards[1:])))], [10.0])
    assert found.mass == pytest.approx(10.0 * volume)


def test_solids_that_no_body_can_be_get_the_inertia_of_their_box() -> None:
    """A surface with a part of it inside out may be closed and have a positive volume."""
    solid = join(box_mesh((0, 0, 0), (1, 1, 1)), box_mesh((0.1, 0.1, -2), (0.9, 0.9, 3)).flipped)
    surface = join(solid, box_mesh((0, 0, 0), (2, 2, 2)))
    moments = np.linalg.eigvalsh(inertial_of([surface]).inertia)
    assert moments[0] > 0.0
    assert moments[0] + moments[1] >= moments[2]
