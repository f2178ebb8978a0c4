"""PLY, DAE and USD files, noise in every format, and folders of meshes."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from datasets import box_obj, write_dsg_net, write_partnet
from gltf_files import PARTS, box, cabinet
from obj_files import obj

import kinmo
from kinmo.core.shape import Shape
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.source_files import fingerprint


def names(shape: Shape) -> list[tuple[str, str]]:
    """Name of the parent and of each part below the root, sorted."""
    inner = [(shape.parts[part.parent], part) for part in shape.parts if part.parent is not None]
    return sorted((above.name, part.name) for above, part in inner)


def test_a_ply_file_with_points_alone_is_no_shape(tmp_path: Path) -> None:
    trimesh.PointCloud(np.random.default_rng(0).random((50, 3))).export(tmp_path / "scan.ply")
    assert list(discover(tmp_path)) == []
    trimesh.util.concatenate(list(PARTS.values())).export(tmp_path / "mesh.ply")
    assert [found.id for found in discover(tmp_path)] == ["mesh"]


DAE = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="inch" meter="0.0254"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="sheet"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s">
<node id="n1" name="chest"><translate>0 0 5</translate>
<node id="n2" name="lid"><translate>0 0 1</translate><instance_geometry url="#g"/></node>
<node id="n3"><instance_geometry url="#g"/></node></node>
<node id="n4" name="lamp"/></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def test_a_dae_file_has_its_own_hierarchy_axis_and_unit(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    (tmp_path / "a.dae").write_text(DAE)
    shape = kinmo.load(tmp_path / "a.dae")
    assert shape.parts[0].name == "chest" and names(shape) == [("chest", ""), ("chest", "lid")]
    heights = {part.name: part.mesh.vertices[:, 2].tolist() for part in shape.parts if part.mesh}
    assert heights == {"lid": [6.0] * 4, "": [5.0] * 4}
    assert (shape.up, shape.metres_per_unit) == ((0.0, 0.0, 1.0), 0.0254)
    notched = DAE.replace("1 1 0 0 1 0</float", "0.2 0.2 0 0 1 0</float")
    (tmp_path / "a.dae").write_text(notched)
    assert next(kinmo.load(tmp_path / "a.dae").meshes()).face_areas.sum() == pytest.approx(0.2)
    deep = DAE.replace('<node id="n4" name="lamp"/>', "<node>" * 5000 + "</node>" * 5000)
    for broken in (DAE[:900], DAE.replace("0 1 2 3</p>", "0 1 2 9</p>"), f'<!DOCTYPE a [<!ENTITY b "c">]>{DAE[21:]}', deep):
        (tmp_path / "a.dae").write_text(broken)
        with pytest.raises(kinmo.InputError, match=r"a\.dae"):
            kinmo.load(tmp_path / "a.dae")


def test_a_dae_file_without_its_materials_keeps_its_meshes(tmp_path: Path) -> None:
    pytest.importorskip("collada")
    bound = "<bind_material><technique_common><instance_material symbol='s' target='#wood'/></technique_common></bind_material>"
    lost = '<library_materials><material id="oak"><instance_effect url="#no"/></material></library_materials>'
    text = DAE.replace('url="#g"/>', f'url="#g">{bound}</instance_geometry>').replace("<library_vis", f"{lost}<library_vis")
    (tmp_path / "a.dae").write_text(text)
    shape = kinmo.load(tmp_path / "a.dae")
    assert (names(shape), shape.repairs) == ([("chest", ""), ("chest", "lid")], ("materials ignored: 1",))


USD = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "{up}"
)
def Xform "chest" (kind = "component") {{
    double3 xformOp:translate = (0, 0, 5)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "sheet" {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    }}
    def Cube "block" {{
        double size = 2
    }}
    def Cylinder "rod" {{
        double height = 4
        double radius = 0.5
        uniform token axis = "X"
    }}
    def Mesh "gone" {{
        token visibility = "invisible"
    }}
    def Cube "proxy" {{
        uniform token purpose = "proxy"
    }}
    def Camera "eye" {{
    }}
    def PointInstancer "knobs" {{
        rel prototypes = [</chest/knobs/knob>]
        int[] protoIndices = [0, 0]
        point3f[] positions = [(0, 0, 3), (0, 0, 4)]
        def Sphere "knob" {{
            double radius = 0.25
        }}
    }}
}}
"""


@pytest.mark.parametrize(("up", "vector"), [("Y", (0.0, 1.0, 0.0)), ("Z", (0.0, 0.0, 1.0))])
def test_the_prims_of_a_usd_stage_are_the_parts(up: str, vector: tuple[float, ...], tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    (tmp_path / "a.usda").write_text(USD.format(up=up))
    shape = kinmo.load(tmp_path / "a.usda")
    assert names(shape) == [("chest", name) for name in ("block", "knobs", "knobs", "rod", "sheet")]
    assert (shape.up, shape.metres_per_unit, shape.repairs) == (vector, 0.01, ("invisible prims ignored: 1",))
    sizes = {part.name: np.ptp(part.mesh.vertices, axis=0).round(3).tolist() for part in shape.parts if part.mesh}
    assert (sizes["block"], sizes["rod"], sizes["sheet"]) == ([2, 2, 2], [4, 1, 1], [1, 1, 0])
    knobs = sorted(part.mesh.vertices[:, 2].mean() for part in shape.parts if part.name == "knobs" and part.mesh)
    assert knobs == pytest.approx([8.0, 9.0], abs=1e-3)
    from pxr import Usd

    (tmp_path / "metres.usda").write_text(USD.format(up=up).replace("upAxis", "metersPerUnit = 0.5\n    upAxis"))
    assert kinmo.load(tmp_path / "metres.usda").metres_per_unit == 0.5
    (tmp_path / "notched.usda").write_text(USD.format(up=up).replace("(1, 1, 0)", "(0.2, 0.2, 0)"))
    (sheet,) = (part.mesh for part in kinmo.load(tmp_path / "notched.usda").parts if part.name == "sheet")
    assert sheet is not None and sheet.face_areas.sum() == pytest.approx(0.2)
    for ending in ("usd", "usdc"):
        Usd.Stage.Open(str(tmp_path / "a.usda")).Export(str(tmp_path / f"b.{ending}"))
        assert names(kinmo.load(tmp_path / f"b.{ending}")) == names(shape)
    (tmp_path / "a.usda").write_text(USD.format(up=up)[:300])
    with pytest.raises(kinmo.InputError, match="expected a readable USD file"):
        kinmo.load(tmp_path / "a.usda")


def test_layers_of_a_usd_stage_count_and_stay_in_its_folder(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "parts.usda").write_text(USD.format(up="Z"))
    (tmp_path / "outside.usda").write_text(USD.format(up="Z"))
    top = tmp_path / "inner" / "a.usda"
    top.write_text("#usda 1.0\n(\n    subLayers = [@./parts.usda@]\n)\n")
    (found,) = discover(top)
    assert [row[0] for row in fingerprint(found)] == ["a.usda", "parts.usda"]
    assert len(found.read().leaves) == 5
    top.write_text("#usda 1.0\n(\n    subLayers = [@../outside.usda@]\n)\n")
    with pytest.raises(kinmo.InputError, match="leads out of the folder"):
        found.read()


@pytest.mark.parametrize(("ending", "module", "extra"), [("dae", "collada", "formats"), ("usda", "pxr", "usd")])
def test_a_missing_library_is_named_with_its_command(
    ending: str, module: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    (tmp_path / f"a.{ending}").write_text("x")
    with pytest.raises(kinmo.InputError, match=rf"is {ending[:3].upper()}: pip install 'kinmo\[{extra}\]' to read it"):
        kinmo.load(tmp_path / f"a.{ending}")


@pytest.mark.parametrize("ending", ["glb", "gltf", "obj", "ply", "stl", "dae", "3mf", "usda", "usdc", "usdz"])
def test_noise_is_an_error_in_every_format(ending: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    header = b"ply\nformat ascii 1.0\nelement vertex 3\nelement face 1\nend_header\n" if ending == "ply" else b""
    for size in (0, 1, 100, 5000):
        (tmp_path / f"a.{ending}").write_bytes(header + rng.integers(0, 256, size, np.uint8).tobytes())
        with pytest.raises(kinmo.InputError):
            kinmo.load(tmp_path / f"a.{ending}")


def layouts(root: Path) -> list[tuple[str, str]]:
    return [(found.layout, found.id) for found in discover(root)]


def test_mesh_files_of_a_folder_are_the_parts_of_one_shape(tmp_path: Path) -> None:
    for name, mesh in PARTS.items():
        mesh.export(tmp_path / f"{name}.{'stl' if name == 'knob' else 'obj'}")
    (found,) = discover(tmp_path)
    assert (found.layout, found.id) == ("mesh_folder", tmp_path.name)
    shape = found.read()
    assert (shape.id, names(shape)) == (found.id, [("", "body"), ("", "door"), ("", "knob")])
    assert shape.guesses["up"] == "up +y (3 mesh files)"
    before = fingerprint(found)
    (tmp_path / "door.obj").write_text("o x\n")
    assert fingerprint(found) != before


def test_files_that_are_shapes_of_their_own_stay_apart(tmp_path: Path) -> None:
    cabinet().write_glb(tmp_path / "a.glb")
    box((1, 1, 1)).export(tmp_path / "b.obj")
    box((1, 1, 1)).export(tmp_path / "c.stl")
    assert layouts(tmp_path) == [("glb", "a"), ("obj", "b"), ("stl", "c")]
    (tmp_path / "a.glb").unlink()
    assert layouts(tmp_path) == [("mesh_folder", tmp_path.name)]
    obj(tmp_path / "b.obj", "o door", "o body")
    assert layouts(tmp_path) == [("obj", "b"), ("stl", "c")], "one file has several objects"
    box((1, 1, 1)).export(tmp_path / "b.obj")
    box((1, 1, 1)).export(tmp_path / "b.stl")
    assert layouts(tmp_path) == [("obj", "b"), ("stl", "b"), ("stl", "c")], "one object in two formats"


def test_shapes_below_a_folder_of_meshes_are_found_too(tmp_path: Path) -> None:
    for name in ("a", "b"):
        box((1, 1, 1)).export(tmp_path / f"{name}.obj")
    (tmp_path / "more").mkdir()
    cabinet().write_glb(tmp_path / "more" / "c.glb")
    assert layouts(tmp_path) == [("mesh_folder", tmp_path.name), ("glb", "c")]


def test_meshes_of_other_formats_are_no_shapes(tmp_path: Path) -> None:
    write_partnet(tmp_path / "1")
    write_dsg_net(tmp_path / "dsg", "7")
    for place in ("robot/meshes", "predicted/meshes"):
        (tmp_path / place).mkdir(parents=True)
        for name in ("a", "b"):
            (tmp_path / place / f"{name}.obj").write_text(box_obj((0, 0, 0), (1, 1, 1)))
    (tmp_path / "robot" / "arm.xml").write_text("<mujoco/>")
    (tmp_path / "predicted" / "joints.json").write_text("{}")
    (tmp_path / "predicted" / "model.urdf").write_text("<robot/>")
    assert layouts(tmp_path) == [("partnet", "1"), ("dsg_net", "storagefurniture-7"), ("mjcf", "arm")]


def test_labels_do_not_apply_to_datasets(tmp_path: Path) -> None:
    np.save(tmp_path / "faces.npy", np.zeros(3, int))
    with pytest.raises(kinmo.InputError, match="--labels: does not apply to"):
        kinmo.load(write_partnet(tmp_path / "1"), labels=tmp_path / "faces.npy")


def test_prepared_shapes_may_have_any_format(tmp_path: Path) -> None:
    found = ShapeSource(obj(tmp_path / "a.obj", "o door", "o body"), "obj", "a")
    assert [row[0] for row in fingerprint(found)] == ["a.obj"]
    from kinmo.features.shape_preparation import prepare_shape

    assert prepare_shape(found.read()).category == ""
