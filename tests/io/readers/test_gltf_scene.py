"""Scenes of glTF files: meshes that show nothing are reported, and mirrored skins face outwards."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from gltf_files import BODY, DOOR, GltfBuilder, cabinet

import kinmo


@pytest.mark.parametrize("fields", [{}, {"primitives": []}])
def test_meshes_without_primitives_are_named(fields: dict[str, Any], tmp_path: Path) -> None:
    made = cabinet()
    made.document["meshes"] += [{"name": "drawer", **fields}, fields]
    roots = made.document["scenes"][0]["nodes"]
    roots += [made.node("drawer", mesh=3), made.node("second", mesh=3), made.node("shelf", mesh=4)]
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert shape.repairs == (
        "mesh 4, which has no triangles, ignored: 1",
        "mesh drawer, which has no triangles, ignored: 1",
    )


def test_many_meshes_without_primitives_are_counted(tmp_path: Path) -> None:
    made = cabinet()
    made.document["meshes"] += [{} for _ in range(9)]
    made.document["scenes"][0]["nodes"] += [made.node(mesh=3 + number) for number in range(9)]
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert len(shape.repairs) == 6
    assert "further meshes without triangles ignored: 4" in shape.repairs


def skinned(path: Path, joints: np.ndarray, weights: np.ndarray, *scales: float, **attributes: np.ndarray) -> trimesh.Trimesh:
    """The surface of a door whose bones are scaled along x, in the scene.

    Args:
        path: file to write.
        joints: two bones [V, 2] of each vertex.
        weights: their weights [V, 2].
        scales: scale of each bone along x.
        attributes: further attributes of the vertices.
    """
    made, nothing = GltfBuilder(), np.zeros_like(joints)
    bones = [made.node(f"bone {i}", scale=[scale, 1.0, 1.0]) for i, scale in enumerate(scales)]
    fields = {
        "JOINTS_0": made.accessor(np.hstack([joints, nothing]).astype(np.uint16)),
        "WEIGHTS_0": made.accessor(np.hstack([weights, nothing]).astype(np.float32)),
        **{name: made.accessor(values.astype(np.float32)) for name, values in attributes.items()},
    }
    made.document["skins"] = [{"joints": bones}]
    door = made.node("door", mesh=made.mesh(DOOR, **fields), skin=0)
    shape = kinmo.load(made.scene(*bones, door, made.node("body", mesh=made.mesh(BODY))).write_glb(path))
    (mesh,) = (part.mesh for part in shape.parts if part.name == "door")
    assert mesh is not None
    if attributes:
        assert mesh.look is not None and mesh.look.colors is not None
        np.testing.assert_allclose(mesh.look.colors[..., :3], np.abs(mesh.triangles), atol=1e-6)
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


ONE = np.tile([1.0, 0.0], (8, 1))


@pytest.mark.parametrize("scale", [-1.0, -0.5, 0.5, 1.0])
def test_skins_of_mirrored_bones_face_outwards(scale: float, tmp_path: Path) -> None:
    found = skinned(tmp_path / "a.glb", np.zeros((8, 2)), ONE, scale, COLOR_0=np.abs(DOOR.vertices) * [abs(scale), 1.0, 1.0])
    assert found.volume == pytest.approx(abs(scale) * DOOR.volume)


@pytest.mark.parametrize("share", [0.1, 0.9])
def test_the_blended_bones_decide_which_side_of_a_skin_is_outside(share: float, tmp_path: Path) -> None:
    weights = np.tile([share, 1.0 - share], (8, 1))
    found = skinned(tmp_path / "a.glb", np.tile([0, 1], (8, 1)), weights, -1.0, 1.0)
    assert found.volume == pytest.approx(0.8 * DOOR.volume)


def test_triangles_that_no_bone_mirrors_keep_their_direction(tmp_path: Path) -> None:
    is_mirrored = DOOR.vertices[:, 2] > DOOR.centroid[2]
    joints = np.where(is_mirrored[:, None], [0, 1], [1, 0])
    colors = np.abs(DOOR.vertices)
    found = skinned(tmp_path / "a.glb", joints, ONE, -1.0, 1.0, COLOR_0=colors)
    heights = found.triangles[:, :, 2]
    ends = np.ptp(heights, axis=1) < 1e-6
    is_front = heights[:, 0] > DOOR.centroid[2]
    np.testing.assert_allclose(found.face_normals[ends & is_front], [[0.0, 0.0, 1.0]] * 2, atol=1e-6)
    np.testing.assert_allclose(found.face_normals[ends & ~is_front], [[0.0, 0.0, -1.0]] * 2, atol=1e-6)
