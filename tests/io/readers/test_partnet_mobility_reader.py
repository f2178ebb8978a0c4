"""The reader of PartNet-Mobility."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from datasets import BOXES, RESULT, joint_data, mobility, write_json, write_partnet_mobility
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from kinmo.core.edge_labels import label_edges, sibling_edges
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.core.motion_types import MotionType
from kinmo.io.discover import discover
from kinmo.io.readers import read_partnet_mobility

one_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=30)


def door_of(shape):
    return next(body for body in shape.mobility.bodies if body.name == "door")


def with_joint(tmp_path, data, joint="hinge"):
    bodies = mobility()
    bodies[1] |= {"joint": joint, "jointData": data}
    return read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", bodies))


def test_parts_are_in_preorder_with_names_and_meshes(tmp_path):
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711"))
    assert [part.id for part in shape.parts] == [0, 1, 2, 3, 4, 5, 6, 7]
    assert [part.parent for part in shape.parts] == [None, 0, 1, 1, 0, 4, 4, 0]
    assert shape.parts[2].name == "vertical_side_panel"
    assert [shape.parts[leaf].id for leaf in shape.leaves] == [2, 3, 5, 6, 7]
    assert len(shape.parts[2].mesh.faces) == 24, "two boxes of six quads"
    low, high = shape.bounds
    np.testing.assert_allclose(low, np.min([box[0] for box in BOXES.values()], axis=0))
    np.testing.assert_allclose(high, np.max([box[1] for box in BOXES.values()], axis=0))
    assert (shape.id, shape.category, shape.partnet_id, shape.layout) == (
        "4711",
        "StorageFurniture",
        "4711",
        "partnet_mobility",
    )
    assert shape.repairs == ()


def test_ids_from_100000_are_not_partnet_annotations(tmp_path):
    assert read_partnet_mobility(write_partnet_mobility(tmp_path / "100015")).partnet_id is None


def test_bodies_own_the_leaves_below_their_parts(tmp_path):
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711"))
    owned = [[shape.parts[leaf].id for leaf in body.leaves] for body in shape.mobility.bodies]
    assert owned == [[2, 3], [5, 6], [7]]
    assert [body.parent for body in shape.mobility.bodies] == [None, 0, 0]
    drawer = shape.mobility.bodies[2].joint
    assert (drawer.kind, drawer.lower, drawer.upper) == (JointKind.PRISMATIC, 0.0, 0.6)


@one_folder
@given(a=st.floats(-180, 180), b=st.floats(-180, 180), scale=st.floats(0.1, 1.04))
def test_any_order_of_limits_describes_the_same_motion(tmp_path, a, b, scale):
    joint = door_of(with_joint(tmp_path, joint_data((0, scale, 0), a, b))).joint
    np.testing.assert_allclose(np.linalg.norm(joint.direction), 1.0)
    if a == b:
        assert not joint.is_limited
        return
    assert joint.lower <= 0.0 <= joint.upper, "the file shows the part at 0"
    sign = float(joint.direction[1])
    stated = np.sort(np.radians([min(a, b), max(a, b)]) * sign)
    inside = [stated + 2 * math.pi * turn for turn in (-1, 0, 1)]
    if a * b <= 0:
        np.testing.assert_allclose([joint.lower, joint.upper], stated, atol=1e-12)
    else:
        widened = np.array([min(stated[0], 0.0), max(stated[1], 0.0)])
        assert any(np.allclose([joint.lower, joint.upper], option, atol=1e-9) for option in [*inside, widened])


@pytest.mark.parametrize(("a", "b", "lower", "upper"), [(-400, -221, -40, 139), (-849, -636, -129, 84), (70, 178, 0, 178)])
def test_a_hinge_range_without_0_is_shifted_by_turns_or_widened(tmp_path, a, b, lower, upper):
    shape = with_joint(tmp_path, joint_data((0, 1, 0), a, b))
    np.testing.assert_allclose(np.degrees([door_of(shape).joint.lower, door_of(shape).joint.upper]), [lower, upper])
    assert any("rest value" in repair for repair in shape.repairs)


def test_limits_from_high_to_low_reverse_the_direction(tmp_path):
    shape = with_joint(tmp_path, joint_data((0, 1, 0), 0, -90))
    joint = door_of(shape).joint
    np.testing.assert_allclose(joint.direction, [0, -1, 0])
    np.testing.assert_allclose([joint.lower, joint.upper], [0, math.pi / 2])
    assert any("reversed" in repair for repair in shape.repairs)


@pytest.mark.parametrize(
    "data", [joint_data((0, 1, 0), noLimit=True), joint_data((0, 1, 0), 5, 5), {"axis": joint_data((0, 1, 0))["axis"]}]
)
def test_no_limit_equal_limits_and_missing_limits_mean_unlimited(tmp_path, data):
    assert not door_of(with_joint(tmp_path, data)).joint.is_limited


@pytest.mark.parametrize(("name", "rotates", "kind"), [("slider", True, "PR"), ("slider", False, "P"), ("screw", False, "PR")])
def test_a_slider_that_rotates_is_a_screw(tmp_path, name, rotates, kind):
    joint = door_of(with_joint(tmp_path, joint_data((0, 1, 0), 0, 0.1, rotates=rotates), name)).joint
    assert joint.kind is JointKind(kind)
    assert joint.upper == 0.1, "a screw's limits are lengths"


@pytest.mark.parametrize("name", ["static", "free", "heavy", "junk", ""])
def test_rigid_bodies_have_no_joint(tmp_path, name):
    shape = with_joint(tmp_path, {}, name)
    assert door_of(shape).joint is None
    assert door_of(shape).parent == (None if name == "free" else 0)
    assert {shape.parts[leaf].id for leaf in shape.mobility.junk} == ({5, 6} if name == "junk" else set())


def test_a_joint_without_parent_is_attached_to_the_base(tmp_path):
    bodies = mobility()
    bodies[1]["parent"] = -1
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", bodies))
    assert door_of(shape).parent == 0
    assert any("no parent" in repair for repair in shape.repairs)


def test_leaves_without_a_body_belong_to_the_base(tmp_path):
    bodies = mobility()
    bodies[1]["parts"] = [{"id": 5}]
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", bodies))
    assert [shape.parts[leaf].id for leaf in shape.mobility.bodies[0].leaves] == [2, 3, 6]
    assert any("no body owns the leaves 6" in repair for repair in shape.repairs)


def test_every_leaf_belongs_to_one_body_even_without_a_base(tmp_path):
    bodies = [{**mobility()[1], "parent": -1}]
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", bodies))
    owned = sorted(leaf for body in shape.mobility.bodies for leaf in body.leaves)
    assert owned == sorted(shape.leaves)


def test_children_of_a_body_without_geometry_move_up(tmp_path):
    bodies = mobility()
    bodies[1]["parent"] = 3
    bodies.append({"id": 3, "parent": 0, "joint": "static", "name": "hinge pin", "parts": [], "jointData": {}})
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", bodies))
    assert len(shape.mobility.bodies) == 3
    assert door_of(shape).parent == 0


def test_a_part_without_surface_is_skipped(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    (folder / "textured_objs" / "original-5.obj").write_text("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n")
    shape = read_partnet_mobility(folder)
    assert [part.id for part in shape.parts] == [0, 1, 2, 3, 4, 5, 7]
    assert "part 6 (handle) has no surface: skipped" in shape.repairs
    assert [shape.parts[leaf].id for leaf in door_of(shape).leaves] == [5]


def test_a_missing_mesh_is_skipped_with_a_note_and_its_part_keeps_the_others(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    for name in ("original-2", "original-6"):
        (folder / "textured_objs" / f"{name}.obj").unlink()
    shape = read_partnet_mobility(folder)
    assert [shape.parts[leaf].id for leaf in shape.leaves] == [2, 3, 5, 6]
    assert len(shape.parts[2].mesh.faces) == 12, "one of two boxes"
    assert shape.repairs == (
        "part 2 (vertical_side_panel): textured_objs/original-2.obj skipped: missing",
        "part 7 (drawer): textured_objs/original-6.obj skipped: missing",
        "body 2 (drawer) has no geometry: skipped",
    )


def test_a_broken_mesh_is_skipped_with_the_reason(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    (folder / "textured_objs" / "original-5.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n")
    expected = "part 6 (handle): textured_objs/original-5.obj skipped: a face names a vertex outside 1..3"
    assert read_partnet_mobility(folder).repairs == (expected,)


def test_an_object_without_any_mesh_is_refused_with_the_first_reason(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    for path in (folder / "textured_objs").iterdir():
        path.write_text("version https://git-lfs.github.com/spec/v1\n")
    with pytest.raises(InputError, match=r"no part has geometry \(part 2 .*original-1\.obj skipped: .*`git lfs pull`"):
        read_partnet_mobility(folder)


def test_meshes_that_are_not_listed_get_one_note(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    for number in (8, 9):
        (folder / "textured_objs" / f"spare-{number}.obj").write_text("")
    (folder / "textured_objs" / "box.mtl").write_text("")
    expected = "result.json does not list spare-8.obj, spare-9.obj in textured_objs: not read"
    assert read_partnet_mobility(folder).repairs == (expected,)


def test_meta_json_decides_between_different_categories(tmp_path):
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", meta={"model_cat": "Box", "anno_id": "1"}))
    assert shape.category == "Box"
    assert any("storage_furniture" in repair or "StorageFurniture" in repair for repair in shape.repairs)


def test_without_meta_json_the_root_part_gives_the_category(tmp_path):
    folder = write_partnet_mobility(tmp_path / "4711")
    (folder / "meta.json").unlink()
    shape = read_partnet_mobility(folder)
    assert shape.category == "StorageFurniture"
    assert any("meta.json" in repair for repair in shape.repairs)


def test_without_a_category_in_meta_json_the_root_part_gives_it(tmp_path):
    shape = read_partnet_mobility(write_partnet_mobility(tmp_path / "4711", meta={"anno_id": "1"}))
    assert (shape.category, shape.partnet_id) == ("StorageFurniture", "1")
    assert "meta.json has no model_cat: category taken from the root part" in shape.repairs


def test_without_any_name_the_category_is_unknown(tmp_path):
    nameless = copy.deepcopy(RESULT)
    nameless[0].update(name="")
    folder = write_partnet_mobility(tmp_path / "4711", result=nameless)
    (folder / "meta.json").unlink()
    shape = read_partnet_mobility(folder)
    assert shape.category == "unknown"
    assert any("meta.json" in repair for repair in shape.repairs)


def test_a_far_origin_of_a_slider_is_dropped(tmp_path):
    data = joint_data((0, 1, 0), 0, 0.1)
    data["axis"]["origin"] = [1e308, 0.0, 0.0]
    shape = with_joint(tmp_path, data, "slider")
    assert np.abs(door_of(shape).joint.pivot).max() < 10.0
    assert any("origin" in repair for repair in shape.repairs)


@pytest.mark.parametrize(("name", "limit"), [("slider", 1e30), ("hinge", 1e9)])
def test_huge_limits_are_dropped(tmp_path, name, limit):
    shape = with_joint(tmp_path, joint_data((0, 1, 0), -limit, limit), name)
    assert not door_of(shape).joint.is_limited
    assert any("far too large" in repair for repair in shape.repairs)


def far_hinge():
    data = joint_data((0, 1, 0))
    data["axis"]["origin"] = [0.0, 1e308, 0.0]
    return data


def broken(change):
    """The three JSON files of the shape after a change."""
    files = {"mobility_v2.json": mobility(), "result.json": copy.deepcopy(RESULT), "meta.json": {"model_cat": "Box"}}
    change(files)
    return files


CONTRADICTIONS = {
    "an unknown part": (lambda f: f["mobility_v2.json"][1].update(parts=[{"id": 77}]), "parts[0].id"),
    "an unknown parent": (lambda f: f["mobility_v2.json"][1].update(parent=9), "[1].parent"),
    "a cycle": (lambda f: f["mobility_v2.json"][0].update(parent=1), "cycle"),
    "a body its own parent": (lambda f: f["mobility_v2.json"][1].update(parent=1), "cycle"),
    "a body twice": (lambda f: f["mobility_v2.json"][2].update(id=1), "[2].id"),
    "a leaf owned twice": (lambda f: f["mobility_v2.json"][2].update(parts=[{"id": 6}]), "leaf 6 belongs to"),
    "an unknown joint": (lambda f: f["mobility_v2.json"][1].update(joint="ball"), "[1].joint"),
    "a zero axis": (lambda f: f["mobility_v2.json"][1].update(jointData=joint_data((0, 0, 0))), "direction"),
    "an axis of two numbers": (lambda f: f["mobility_v2.json"][1].update(jointData=joint_data((0, 1))), "direction"),
    "a limit that is no number": (lambda f: f["mobility_v2.json"][1].update(jointData=joint_data((0, 1, 0), "a")), "limit.a"),
    "a limit of NaN": (lambda f: f["mobility_v2.json"][1].update(jointData=joint_data((0, 1, 0), math.nan)), "limit.a"),
    "a huge limit": (lambda f: f["mobility_v2.json"][1].update(jointData=joint_data((0, 1, 0), 10**400)), "limit.a"),
    "an axis far away": (lambda f: f["mobility_v2.json"][1].update(jointData=far_hinge()), "jointData.axis.origin"),
    "no joint data": (lambda f: f["mobility_v2.json"][1].pop("jointData"), "jointData"),
    "no bodies": (lambda f: f["mobility_v2.json"].clear(), "list of bodies"),
    "a node twice": (lambda f: f["result.json"][0]["children"][2].update(id=1), "children[2].id"),
    "a node without id": (lambda f: f["result.json"][0]["children"][2].pop("id"), "children[2].id"),
    "two roots": (lambda f: f["result.json"].append({"id": 99, "name": "x", "objs": []}), "one root"),
    "a mesh outside": (lambda f: f["result.json"][0]["children"][2].update(objs=["../../secret"]), "leads out"),
    "an absolute mesh": (lambda f: f["result.json"][0]["children"][2].update(objs=["/etc/passwd"]), "leads out"),
    "a mesh that is a number": (lambda f: f["result.json"][0]["children"][2].update(objs=[7]), "objs[0]"),
    "a mesh with a null byte": (lambda f: f["result.json"][0]["children"][2].update(objs=["a\0b"]), "objs[0]"),
    "no geometry at all": (lambda f: f["result.json"][0].update(children=[]), "no part has geometry"),
    "a category that is a list": (lambda f: f["meta.json"].update(model_cat=[]), "model_cat"),
}


@pytest.mark.parametrize("kind", CONTRADICTIONS)
def test_a_contradiction_is_an_error_with_file_and_field(tmp_path, kind):
    change, expected = CONTRADICTIONS[kind]
    folder = write_partnet_mobility(tmp_path / "4711")
    for name, value in broken(change).items():
        write_json(folder / name, value)
    with pytest.raises(InputError) as caught:
        read_partnet_mobility(folder)
    assert expected in str(caught.value)
    assert str(tmp_path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.real
def test_edges_can_express_98_percent_of_real_joints(real_objects):
    joints = expressed = 0
    for found in discover(real_objects[0].parents[1]):
        shape = found.read()
        assert sorted(leaf for body in shape.mobility.bodies for leaf in body.leaves) == sorted(shape.leaves)
        types = {index: MotionType.R_V_S for index, _ in shape.mobility.movable()}
        labels = label_edges(shape, shape.mobility, sibling_edges(shape), types)
        joints += len(types)
        expressed += len(set(labels.bodies.tolist()) - {-1})
    assert expressed / joints >= 0.98
