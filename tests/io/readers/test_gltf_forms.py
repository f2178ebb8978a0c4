"""The legal forms of glTF files: where their data are, how they are stored, and what moves the meshes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gltf_files import BODY, DOOR, PARTS, GltfBuilder, box, cabinet
from scipy.spatial.transform import Rotation

import kinmo
from kinmo.core.shape import Shape
from kinmo.io.discover import discover
from kinmo.io.source_files import fingerprint

DRAWER = box((0.8, 0.3, 0.4))


def leaf_bounds(shape: Shape) -> dict[str, np.ndarray]:
    """Corners of the boxes of the leaves by name."""
    leaves = [shape.parts[leaf] for leaf in shape.leaves]
    return {
        part.name: np.array([part.mesh.vertices.min(axis=0), part.mesh.vertices.max(axis=0)]) for part in leaves if part.mesh
    }


def assert_cabinet(shape: Shape, tolerance: float = 1e-6) -> None:
    found = leaf_bounds(shape)
    assert found.keys() == PARTS.keys()
    for name, mesh in PARTS.items():
        np.testing.assert_allclose(found[name], mesh.bounds, atol=tolerance)


@pytest.mark.parametrize("form", ["glb", "data URI", "GLB with a data URI", "binary file", "wrong ending"])
def test_the_place_of_the_data_does_not_matter(form: str, tmp_path: Path) -> None:
    made = cabinet()
    if form == "glb":
        path = made.write_glb(tmp_path / "a.glb")
    elif form == "data URI":
        path = made.write_gltf(tmp_path / "a.gltf")
    elif form == "GLB with a data URI":
        made.write_gltf(tmp_path / "b.gltf")
        made.binary = b""
        (tmp_path / "b.gltf").unlink()
        path = made.write_glb(tmp_path / "a.glb")
    elif form == "binary file":
        path = made.write_gltf(tmp_path / "a.gltf", "the data.bin")
    else:
        path = made.write_glb(tmp_path / "a.gltf")
    shape = kinmo.load(path)
    assert_cabinet(shape)
    assert (shape.category, shape.layout, shape.repairs) == ("StorageFurniture", "glb", ())


def test_a_change_of_the_binary_file_is_noticed(tmp_path: Path) -> None:
    (found,) = discover(cabinet().write_gltf(tmp_path / "a.gltf", "a.bin"))
    before = fingerprint(found)
    assert [row[0] for row in before] == ["a.gltf", "a.bin"]
    (tmp_path / "a.bin").write_bytes((tmp_path / "a.bin").read_bytes() + b"\0")
    assert fingerprint(found) != before


def test_a_missing_or_outside_binary_file_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    path = cabinet().write_gltf(tmp_path / "inner" / "a.gltf", "../secret.bin")
    with pytest.raises(kinmo.InputError, match=r"a\.gltf: buffers\[0\]\.uri: \.\./secret\.bin: leads out of the folder"):
        kinmo.load(path)
    path = cabinet().write_gltf(tmp_path / "a.gltf", "b.bin")
    (tmp_path / "b.bin").unlink()
    with pytest.raises(kinmo.InputError, match=r"a\.gltf: buffers\[0\]\.uri: b\.bin is missing"):
        kinmo.load(path)


@pytest.mark.parametrize("dtype", ["int8", "uint8", "int16", "uint16"])
@pytest.mark.parametrize("normalised", [False, True])
def test_quantised_positions_are_read(dtype: str, normalised: bool, tmp_path: Path) -> None:
    made = GltfBuilder()
    limit = np.iinfo(dtype).max
    roots = []
    for name, mesh in PARTS.items():
        low, size = mesh.bounds[0], np.ptp(mesh.bounds, axis=0)
        steps = np.round((mesh.vertices - low) / size * limit).astype(dtype)
        position = made.accessor(steps, normalized=normalised)
        scale = (size if normalised else size / limit).tolist()
        roots.append(made.node(name, mesh=made.mesh(mesh, POSITION=position), translation=low.tolist(), scale=scale))
    made.document |= {"extensionsUsed": ["KHR_mesh_quantization"], "extensionsRequired": ["KHR_mesh_quantization"]}
    assert_cabinet(kinmo.load(made.scene(*roots).write_glb(tmp_path / "a.glb")))


def test_sparse_accessors_replace_numbers(tmp_path: Path) -> None:
    made = GltfBuilder()
    moved = np.array([3, 5], np.uint16)
    for name in ("body", "door"):
        mesh, base = PARTS[name], PARTS[name].vertices.astype(np.float32)
        base[moved] = 99.0
        indices, values = made.view(moved.tobytes()), made.view(mesh.vertices[moved].astype(np.float32).tobytes())
        places = {"bufferView": indices, "componentType": 5123}
        sparse = {"count": 2, "indices": places, "values": {"bufferView": values}}
        made.node(name, mesh=made.mesh(mesh, POSITION=made.accessor(base, sparse=sparse)))
    found = leaf_bounds(kinmo.load(made.scene(0, 1).write_glb(tmp_path / "a.glb")))
    np.testing.assert_allclose(found["body"], BODY.bounds, atol=1e-6)
    np.testing.assert_allclose(found["door"], DOOR.bounds, atol=1e-6)


def instanced(**columns: np.ndarray) -> GltfBuilder:
    made = GltfBuilder()
    attributes = {name: made.accessor(values.astype(np.float32)) for name, values in columns.items()}
    body = made.node("body", mesh=made.mesh(BODY))
    extensions = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    drawer = made.node("drawer", mesh=made.mesh(DRAWER), extensions=extensions, translation=[0.0, 0.0, 1.0])
    made.document["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    return made.scene(made.node("chest", children=[body, drawer]))


def test_instances_are_parts(tmp_path: Path) -> None:
    shifts = np.array([[0.0, -0.6, 0.0], [0.0, 0.0, 0.0], [0.0, 0.6, 0.0]])
    turn = Rotation.from_rotvec([0.0, np.pi / 2, 0.0]).as_quat()
    shape = kinmo.load(
        instanced(TRANSLATION=shifts, ROTATION=np.tile(turn, (3, 1)), SCALE=np.full((3, 3), 0.5)).write_glb(tmp_path / "a.glb")
    )
    drawers = [part for part in shape.parts if part.name == "drawer"]
    assert [part.parent for part in drawers] == [0, 0, 0]
    centres = sorted(part.mesh.vertices.mean(axis=0)[1] for part in drawers if part.mesh)
    np.testing.assert_allclose(centres, [-0.6, 0.0, 0.6], atol=1e-6)
    for part in drawers:
        assert part.mesh is not None
        np.testing.assert_allclose(np.ptp(part.mesh.vertices, axis=0), [0.2, 0.15, 0.4], atol=1e-6)


@pytest.mark.parametrize(
    "columns", [{}, {"TRANSLATION": np.zeros((3, 3)), "SCALE": np.ones((2, 3))}, {"_COLOR": np.zeros((3, 3))}], ids=str
)
def test_instances_without_a_place_are_refused_by_name(columns: dict[str, np.ndarray], tmp_path: Path) -> None:
    with pytest.raises(kinmo.InputError, match="EXT_mesh_gpu_instancing needs translations"):
        kinmo.load(instanced(**columns).write_glb(tmp_path / "a.glb"))


def test_joints_alone_place_a_mesh_with_a_skin(tmp_path: Path) -> None:
    made, skins, children = GltfBuilder(), [], []
    for name, mesh in PARTS.items():
        bone = made.node(f"{name} bone", translation=[1.0, 0.0, 0.0])
        inverse = np.diag([0.01, 0.01, 0.01, 1.0])
        inverse[:3, 3] = -1.0, 0.0, 0.0
        stored = made.accessor(np.ascontiguousarray(inverse.T, np.float32).reshape(1, 16))
        skins.append({"joints": [bone], "inverseBindMatrices": stored})
        count = len(mesh.vertices)
        joints = made.accessor(np.zeros((count, 4), np.uint8))
        weights = made.accessor(np.tile(np.array([255, 0, 0, 0], np.uint8), (count, 1)), normalized=True)
        position = made.accessor((100.0 * mesh.vertices).astype(np.float32))
        number = made.mesh(mesh, POSITION=position, JOINTS_0=joints, WEIGHTS_0=weights)
        children += [bone, made.node(name, mesh=number, skin=len(skins) - 1, translation=[9.0, 9.0, 9.0])]
    made.document["skins"] = skins
    assert_cabinet(kinmo.load(made.scene(made.node("Armature", children=children)).write_glb(tmp_path / "a.glb")), 1e-5)


def test_vertices_between_joints_follow_their_weights(tmp_path: Path) -> None:
    made = GltfBuilder()
    bones = [made.node("a"), made.node("b", translation=[0.0, 4.0, 0.0])]
    weights = np.column_stack([0.5 - DOOR.vertices[:, 1] / 1.8, 0.5 + DOOR.vertices[:, 1] / 1.8, *np.zeros((2, 8))])
    joints = made.accessor(np.tile(np.array([0, 1, 0, 0], np.uint16), (8, 1)))
    mesh = made.mesh(DOOR, JOINTS_0=joints, WEIGHTS_0=made.accessor(weights.astype(np.float32)))
    made.document["skins"] = [{"joints": bones}]
    roots = [*bones, made.node("door", mesh=mesh, skin=0), made.node("body", mesh=made.mesh(BODY))]
    found = leaf_bounds(kinmo.load(made.scene(*roots).write_glb(tmp_path / "a.glb")))["door"]
    np.testing.assert_allclose(found[:, 1], [-0.9, 4.9], atol=1e-5)


def test_morph_targets_points_and_hidden_nodes_are_named(tmp_path: Path) -> None:
    made = cabinet()
    primitive = made.document["meshes"][0]["primitives"][0]
    primitive["targets"] = [{"POSITION": 0}]
    made.document["meshes"][1]["primitives"].append({"attributes": {"POSITION": 0}, "mode": 0})
    hidden = made.node("hidden", mesh=0, extensions={"KHR_node_visibility": {"visible": False}})
    made.document["scenes"][0]["nodes"].append(hidden)
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert_cabinet(shape)
    assert shape.repairs == ("hidden nodes ignored: 1", "morph targets ignored: 1", "points and lines ignored: 1")


def test_wrappers_and_other_scenes_are_dropped(tmp_path: Path) -> None:
    made = cabinet()
    top = made.document["scenes"][0]["nodes"][0]
    turn = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]
    back = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1]
    outer = made.node("Sketchfab_model", children=[made.node("root", children=[top], matrix=turn)], matrix=back)
    made.document["nodes"][top]["name"] = "GLTF_SceneRootNode"
    made.document["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    floor = made.node("floor", mesh=made.mesh(box((50.0, 0.01, 50.0))))
    made.document |= {"scene": 1, "scenes": [{"nodes": [floor]}, {"nodes": [made.node("Camera", camera=0), outer]}]}
    shape = kinmo.load(made.write_glb(tmp_path / "a.glb"))
    assert_cabinet(shape)
    assert (shape.parts[0].name, shape.category, shape.guesses["category"]) == ("GLTF_SceneRootNode", "", "category unknown")


@pytest.mark.parametrize("wrapper", ["Refrigerator", "refrigerator"])
def test_a_wrapper_may_name_the_category(wrapper: str, tmp_path: Path) -> None:
    made = cabinet()
    top = made.document["scenes"][0]["nodes"][0]
    made.document["nodes"][top]["name"] = "RootNode"
    shape = kinmo.load(made.scene(made.node(wrapper, children=[top])).write_glb(tmp_path / "a.glb"))
    assert shape.category == "Refrigerator"


def test_meshes_compressed_with_draco_are_read(tmp_path: Path) -> None:
    draco = pytest.importorskip("DracoPy")
    made = GltfBuilder()
    roots = []
    for name, mesh in PARTS.items():
        data = draco.encode(mesh.vertices.astype(np.float32), faces=mesh.faces.astype(np.uint32), quantization_bits=20)
        number = made.mesh(mesh)
        primitive = made.document["meshes"][number]["primitives"][0]
        for accessor in (primitive["attributes"]["POSITION"], primitive["indices"]):
            del made.document["accessors"][accessor]["bufferView"]
        packed = {"bufferView": made.view(data), "attributes": {"POSITION": 0}}
        primitive["extensions"] = {"KHR_draco_mesh_compression": packed}
        roots.append(made.node(name, mesh=number))
    made.document |= {name: ["KHR_draco_mesh_compression"] for name in ("extensionsUsed", "extensionsRequired")}
    path = made.scene(*roots).write_glb(tmp_path / "a.glb")
    assert_cabinet(kinmo.load(path), 1e-4)
    data = path.read_bytes()
    path.write_bytes(data.replace(b"DRACO", b"DRACX"))
    with pytest.raises(kinmo.InputError, match="KHR_draco_mesh_compression: cannot be decompressed"):
        kinmo.load(path)


@pytest.mark.parametrize("extension", ["EXT_meshopt_compression", "KHR_meshopt_compression"])
def test_data_compressed_with_meshopt_are_read(extension: str, tmp_path: Path) -> None:
    meshopt = pytest.importorskip("meshopt")
    made = GltfBuilder()
    roots = []
    for name, mesh in PARTS.items():
        number = made.mesh(mesh)
        primitive = made.document["meshes"][number]["primitives"][0]
        for accessor, array, mode in (
            (primitive["attributes"]["POSITION"], mesh.vertices.astype(np.float32), "ATTRIBUTES"),
            (primitive["indices"], mesh.faces.astype(np.uint16).reshape(-1), "TRIANGLES"),
        ):
            data = meshopt.encode_gltf_buffer(array, mode)
            stride = array.itemsize * (3 if mode == "ATTRIBUTES" else 1)
            view = made.view(data)
            place = {key: made.document["bufferViews"][view][key] for key in ("buffer", "byteOffset", "byteLength")}
            packed = {**place, "byteStride": stride, "count": len(array), "mode": mode}
            made.document["bufferViews"][view] = {"buffer": 1, "byteLength": array.nbytes, "extensions": {extension: packed}}
            made.document["accessors"][accessor]["bufferView"] = view
        roots.append(made.node(name, mesh=number))
    fallback = {"byteLength": 10**6, "extensions": {extension: {"fallback": True}}}
    made.document |= {"buffers": [{"byteLength": len(made.binary)}, fallback], "extensionsRequired": [extension]}
    assert_cabinet(kinmo.load(made.scene(*roots).write_glb(tmp_path / "a.glb")))


def test_a_missing_decoder_is_named_with_the_command_that_installs_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "DracoPy", None)
    made = GltfBuilder()
    number = made.mesh(BODY)
    primitive = made.document["meshes"][number]["primitives"][0]
    del made.document["accessors"][primitive["attributes"]["POSITION"]]["bufferView"]
    packed = {"bufferView": made.view(b"DRACO"), "attributes": {"POSITION": 0}}
    primitive["extensions"] = {"KHR_draco_mesh_compression": packed}
    path = made.scene(made.node("a", mesh=number)).write_glb(tmp_path / "a.glb")
    with pytest.raises(kinmo.InputError, match=r"is compressed with Draco: pip install 'kinmo\[formats\]' to read it"):
        kinmo.load(path)
