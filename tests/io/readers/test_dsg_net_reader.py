"""The reader of DSG-Net and StructureNet."""

from __future__ import annotations

import json
from pathlib import Path

import articulated
import h5py
import numpy as np
import pytest
from datasets import BOXES, LEAVES, RESULT, tree, write_dsg_net, write_json
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from kinmo.core.errors import InputError
from kinmo.core.oriented_box import CORNER_SIGNS
from kinmo.io.readers import read_dsg_net
from kinmo.io.readers.deformed_cube import CubeMesh

CUBE = CORNER_SIGNS
CUBE_FACES = articulated.CUBE_FACES + 1
"""Faces with vertices counted from 1, as in the file."""


def cube_info() -> dict[str, np.ndarray]:
    """The solver of a cube with uniform weights. The neighbours of a corner are along its edges."""
    neighbour = np.array([[j + 1 for j in range(8) if np.abs(CUBE[i] - CUBE[j]).sum() == 2] for i in range(8)])
    laplacian = 3.0 * np.eye(8)
    for i, row in enumerate(neighbour):
        laplacian[i, row - 1] = -1.0
    vdiff = 0.5 * (CUBE[:, None] - CUBE[neighbour - 1])
    shifting = np.outer(np.ones(8), np.arange(8.0))  # the solution has no fixed position: the solver need not be symmetric
    solver = np.linalg.pinv(laplacian) + shifting
    return {"neighbour": neighbour, "vdiff": vdiff, "recon": solver, "ref_F": CUBE_FACES, "ref_V": CUBE}


def test_parts_have_their_meshes(tmp_path):
    shape = read_dsg_net(write_dsg_net(tmp_path))
    assert [part.id for part in shape.parts] == list(range(8))
    assert shape.parts[7].name == "drawer"
    low, high = BOXES["original-6"]
    np.testing.assert_allclose(shape.parts[7].mesh.vertices.min(axis=0), low)
    np.testing.assert_allclose(shape.parts[7].mesh.vertices.max(axis=0), high)
    assert (shape.category, shape.layout, shape.partnet_id, shape.mobility) == ("StorageFurniture", "dsg_net", "4711", None)


def test_points_become_a_surface_of_the_same_extent(tmp_path):
    shape = read_dsg_net(write_dsg_net(tmp_path, geometry="geo"))
    for part in shape.parts:
        if part.mesh is None:
            continue
        low, high = map(np.array, BOXES[LEAVES[part.id][0]])
        spacing = 4 * np.linalg.norm(high - low) / np.sqrt(1000)
        np.testing.assert_allclose(part.mesh.vertices.min(axis=0), low, atol=spacing)
        np.testing.assert_allclose(part.mesh.vertices.max(axis=0), high, atol=spacing)


def test_points_of_a_plane_become_a_surface_of_the_same_area(tmp_path):
    rng = np.random.default_rng(0)
    plane = np.column_stack([rng.random((1000, 2)), np.zeros(1000)])
    turn = Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix()
    node = {"id": 0, "label": "table", "geo": (plane @ turn.T).ravel().tolist()}
    mesh = read_dsg_net(write_json(tmp_path / "a.json", node)).parts[0].mesh
    flat = mesh.vertices @ turn
    np.testing.assert_allclose(flat[:, 2], 0.0, atol=1e-9)
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert 0.8 < area < 1.3


def test_a_part_with_a_negative_id_finds_its_points_by_its_parent(tmp_path):
    path = write_dsg_net(tmp_path, geometry="geo")
    data = json.loads(path.read_text())
    data["children"][1]["children"].append({"id": -1, "label": "other"})
    write_json(path, data)
    file = tmp_path / "storagefurniture_geo" / "4711.npz"
    parts = np.load(file)["parts"]
    np.savez(file, parts=parts, other_ids=np.array([4]), other_parts=parts[7:8] + 10.0)
    shape = read_dsg_net(path)
    other = next(part for part in shape.parts if part.id == -1)
    assert other.mesh.vertices.min() > 8.0


def test_the_id_of_a_numbered_file_begins_with_its_category(tmp_path):
    assert read_dsg_net(write_dsg_net(tmp_path, "12")).id == "storagefurniture-12"
    assert read_dsg_net(write_dsg_net(tmp_path, "made-12")).id == "made-12"


@pytest.mark.parametrize("kind", ["missing", "short", "wrong shape", "nan", "text", "cut", "pickle"])
def test_wrong_points_are_an_error_with_their_file(tmp_path, kind):
    path = write_dsg_net(tmp_path, geometry="geo")
    file = tmp_path / "storagefurniture_geo" / "4711.npz"
    parts = np.load(file)["parts"]
    if kind == "missing":
        file.unlink()
    elif kind == "short":
        np.savez(file, parts=parts[:6])
    elif kind == "wrong shape":
        np.savez(file, parts=parts[:, :, :2])
    elif kind == "nan":
        parts[7, 3] = np.nan
        np.savez(file, parts=parts)
    elif kind == "text":
        file.write_text("not an archive")
    elif kind == "cut":
        file.write_bytes(file.read_bytes()[:1000])
    else:
        np.savez(file, parts=np.array([{"a": 1}], object))
    with pytest.raises(InputError, match="4711"):
        read_dsg_net(path)


def test_deformation_gradients_without_their_cube_are_an_error(tmp_path):
    path = write_dsg_net(tmp_path, geometry="none")
    (tmp_path / "storagefurniture_dgeo").mkdir()
    np.savez(tmp_path / "storagefurniture_dgeo" / "4711.npz", LOGR=np.zeros((8, 8, 3)), S=np.zeros((8, 8, 6)))
    with pytest.raises(InputError, match=r"storagefurniture_dgeo.*cube_meshinfo\.mat"):
        read_dsg_net(path)


def save_version_7_3(path: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write a file like MATLAB 7.3: HDF5 after a header of 512 bytes, with arrays column by column."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in arrays.items():
            file[name] = values.T
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))


@pytest.mark.parametrize("save", [savemat, save_version_7_3])
def test_deformation_gradients_give_the_deformed_cube_in_its_box(tmp_path, save):
    turn = Rotation.from_rotvec([0.2, -0.4, 0.5])
    stretch = np.diag([0.3, 0.6, 0.9])
    x, y, z = turn.as_rotvec()
    log_entries = np.array([-z, y, -x])  # entries (1,2), (1,3), (2,3) of the skew matrix
    box = [1.0, 2.0, 3.0, 0.6, 1.2, 1.8, *turn.as_matrix()[:, 0], *turn.as_matrix()[:, 1]]
    node = tree(RESULT[0]["children"][2]) | {"box": [float(value) for value in box]}
    path = write_json(tmp_path / "chair_hier" / "1.json", {"id": 0, "label": "chair", "children": [node]})
    save(tmp_path / "cube_meshinfo.mat", cube_info())
    gradients = np.tile(log_entries, (8, 8, 1)), np.tile([0.3, 0, 0, 0.6, 0, 0.9], (8, 8, 1))
    (tmp_path / "chair_dgeo").mkdir()
    np.savez(tmp_path / "chair_dgeo" / "1.npz", LOGR=gradients[0], S=gradients[1])
    mesh = read_dsg_net(path).parts[1].mesh
    np.testing.assert_allclose(mesh.vertices, CUBE @ stretch @ turn.as_matrix().T + [1, 2, 3], atol=1e-9)
    np.testing.assert_array_equal(mesh.faces, CUBE_FACES - 1)


def test_identity_gradients_leave_the_cube_unchanged():
    info = cube_info()
    cube = CubeMesh(info["neighbour"] - 1, info["vdiff"], info["recon"], (CUBE_FACES - 1).astype(np.uint32))
    vertices = cube.decode(np.zeros((8, 3)), np.tile([1.0, 0, 0, 1, 0, 1], (8, 1)))
    np.testing.assert_allclose(vertices - vertices.mean(axis=0), CUBE, atol=1e-12)
