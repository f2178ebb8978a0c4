"""Patches of a mesh: loose pieces divided at concave creases."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from kinmo.core.loose_pieces import is_closed, pieces_of_faces
from kinmo.core.shape import Mesh, join
from kinmo.core.surface_patches import patches_of_faces


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(np.array(solid.vertices), np.array(solid.faces, np.uint32))


def block(low: tuple[float, ...], high: tuple[float, ...]) -> Mesh:
    return mesh_of(trimesh.creation.box(bounds=(low, high)))


def patches_of(*parts: Mesh, most: int = 100) -> NDArray[np.int64]:
    whole = join(*parts)
    return patches_of_faces(whole, pieces_of_faces(whole), most=most)


def is_one_patch_each(patches: NDArray[np.int64], parts: list[Mesh]) -> bool:
    """True if the faces of every part are one patch that no other part has."""
    origin = np.repeat(np.arange(len(parts)), [len(part.faces) for part in parts])
    return len(np.unique(np.column_stack([origin, patches]), axis=0)) == len(parts) == len(np.unique(patches))


@given(
    height=st.floats(0.1, 2.0),
    depth=st.floats(0.05, 0.9),
    turn=st.floats(0.0, 3.1),
    flipped=st.booleans(),
)
def test_a_door_flush_with_a_frame_is_a_patch_of_its_own(height: float, depth: float, turn: float, flipped: bool) -> None:
    frame = [
        block((-1.0, 0.0, -1.0), (1.0, height, 0.0)),
        block((-1.0, height, -1.0), (1.0, height + 0.2, depth)),
        block((-1.0, 0.0, 0.0), (0.0, height, depth)),
    ]
    door = block((0.0, 0.0, 0.0), (1.0, height, depth))
    rotation = trimesh.transformations.rotation_matrix(turn, [0.3, 1.0, 0.2])
    parts = [Mesh(trimesh.transform_points(part.vertices, rotation), part.faces) for part in [*frame, door]]
    if flipped:
        parts = [Mesh(part.vertices, part.faces[:, ::-1].copy()) for part in parts]
    assert len(np.unique(pieces_of_faces(join(*parts)))) == 1
    assert is_one_patch_each(patches_of(*parts), parts)


@pytest.mark.parametrize(
    "solid",
    [
        trimesh.creation.icosphere(),
        trimesh.creation.cylinder(1.0, 2.0),
        trimesh.creation.torus(1.0, 0.3, 48, 24),
        trimesh.creation.annulus(0.5, 1.0, 1.0, sections=48),
        trimesh.creation.capsule(),
    ],
    ids=["ball", "cylinder", "ring", "tube", "capsule"],
)
def test_a_smooth_or_convex_solid_is_one_patch(solid: trimesh.Trimesh) -> None:
    assert patches_of(mesh_of(solid)).max() == 0
    assert is_closed(mesh_of(solid))


def test_a_knob_on_a_door_is_a_patch_of_its_own() -> None:
    door = block((0.0, 0.0, 0.0), (1.0, 1.0, 0.1))
    around = [block((0.4, 0.4, 0.1), (0.6, 0.6, 0.2))]
    fronts = [
        block((0.0, 0.0, 0.0), (0.4, 1.0, 0.1)),
        block((0.4, 0.0, 0.0), (0.6, 0.4, 0.1)),
        block((0.4, 0.4, 0.0), (0.6, 0.6, 0.1)),
    ]
    assert is_one_patch_each(patches_of(door, *around), [door, *around])
    assert is_one_patch_each(patches_of(*fronts, *around), [*fronts, *around])


@given(count=st.integers(2, 12), most=st.integers(1, 14), seed=st.integers(0, 2**31))
def test_there_are_not_too_many_patches_and_none_crosses_loose_pieces(count: int, most: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    blocks = [block((float(i), 0.0, 0.0), (i + 1.0, *rng.choice([0.3, 0.6, 1.0], 2))) for i in range(count)]
    far = [block((float(3 * i), 5.0, 0.0), (3 * i + 1.0, 6.0, 1.0)) for i in range(rng.integers(0, 4))]
    whole = join(*blocks, *far)
    pieces = pieces_of_faces(whole)
    patches = patches_of_faces(whole, pieces, most=most)
    assert patches.max() + 1 == len(np.unique(patches)) == max(int(pieces.max()) + 1, min(most, count + len(far)))
    assert len(np.unique(np.column_stack([pieces, patches]), axis=0)) == len(np.unique(patches))


def test_an_open_or_welded_mesh_is_not_closed() -> None:
    cube = block((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    assert is_closed(cube)
    assert not is_closed(Mesh(cube.vertices, cube.faces[1:]))
    assert not is_closed(join(cube, block((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))))
