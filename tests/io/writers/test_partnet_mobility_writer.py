"""The writer of PartNet-Mobility: its reader and simulators get what was written."""

import json
import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from articulated import articulated_shapes, shape_of_boxes
from exports import write_partnet_mobility, write_urdf
from hypothesis import given, settings
from scipy.spatial.transform import Rotation

from kinmo.core.categories import canonical_category
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.evaluation import metrics
from kinmo.io.readers import read_partnet_mobility


def around_rest(shape):
    """The shape with joint ranges that contain the pose of the file, as in real data."""
    bodies = []
    for body in shape.mobility.bodies:
        joint = body.joint
        if joint is not None and joint.is_limited:
            joint = replace(joint, rest=0.5 * (joint.lower + joint.upper))
        bodies.append(replace(body, joint=joint))
    return replace(shape, mobility=Mobility(tuple(bodies), shape.mobility.junk))


@settings(max_examples=25)
@given(articulated_shapes())
def test_the_reader_gets_what_was_written(tmp_path_factory, shape):
    shape = around_rest(shape)
    folder = write_partnet_mobility(shape, shape.mobility, tmp_path_factory.mktemp("labels") / shape.id)
    found = read_partnet_mobility(folder)
    assert (found.id, found.category) == (shape.id, canonical_category(shape.category))
    assert [(p.id, p.parent, p.children) for p in found.parts] == [(p.id, p.parent, p.children) for p in shape.parts]
    for mesh, written in zip(found.meshes(), shape.meshes(), strict=True):
        assert np.array_equal(mesh.vertices, written.vertices)
        assert np.array_equal(mesh.faces, written.faces)
    for body, written in zip(found.mobility.bodies, shape.mobility.bodies, strict=True):
        assert (body.leaves, body.parent) == (written.leaves, written.parent)
        assert (body.joint is None) == (written.joint is None)
        if written.joint is not None:
            assert_same_joint(body.joint, written.joint)


@settings(max_examples=15)
@given(articulated_shapes(ups=((0.0, 1.0, 0.0), (0.6, 0.0, 0.8))))
def test_its_urdf_is_the_robot_of_the_urdf_writer_with_other_names(tmp_path_factory, shape):
    folder = tmp_path_factory.mktemp("labels")
    ours = ET.parse(write_urdf(shape, shape.mobility, folder / "ours")).getroot()
    written = write_partnet_mobility(shape, shape.mobility, folder / "theirs")
    theirs = ET.parse(written / "mobility.urdf").getroot()
    names = dict(zip(link_names(theirs), link_names(ours), strict=True))
    assert all(re.fullmatch(r"base|link_\d+(_slide)?", name) for name in names)
    for joint, expected in zip(theirs.iter("joint"), ours.iter("joint"), strict=True):
        assert joint.get("type") == expected.get("type")
        assert [names[joint.find(end).get("link")] for end in ("parent", "child")] == [
            expected.find(end).get("link") for end in ("parent", "child")
        ]
        for field in ("origin", "axis", "limit"):
            assert joint.find(field).attrib == expected.find(field).attrib
    for one, other in zip(visual_bounds(theirs, written), visual_bounds(ours, folder / "ours"), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


def test_semantics_list_every_moving_link_with_its_joint(tmp_path):
    joint = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), 0.0, 1.0)
    boxes = [((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1)), ((2, 0, 0), (3, 1, 1))]
    bodies = (Body(0, "body", (1,)), Body(1, "upper door", (2,), 0, joint), Body(2, "handle", (3,), 1))
    folder = write_partnet_mobility(shape_of_boxes(boxes, bodies), Mobility(bodies), tmp_path / "7")
    assert (folder / "semantics.txt").read_text() == "base heavy body\nlink_1 hinge upper_door\n"


def link_names(robot):
    return [link.get("name") for link in robot.iter("link")]


def visual_bounds(robot, folder):
    """Corners of the bounding box of each visual, in the frame of its link."""
    for visual in robot.iter("visual"):
        file = folder / visual.find("geometry/mesh").get("filename")
        place = visual.find("origin")
        rotation = Rotation.from_euler("xyz", np.array(place.get("rpy").split(), float))
        points = rotation.apply(trimesh.load(file, process=False).vertices) + np.array(place.get("xyz").split(), float)
        yield np.stack([points.min(axis=0), points.max(axis=0)])


def assert_same_joint(found, written):
    assert found.kind is written.kind
    assert found.direction == pytest.approx(written.direction)
    assert found.pivot == pytest.approx(written.pivot)
    assert found.is_limited == written.is_limited
    if written.is_limited:
        assert found.lower - found.rest == pytest.approx(written.lower - written.rest)
        assert found.upper - found.rest == pytest.approx(written.upper - written.rest)
        assert metrics.range_iou(found, replace(written, lower=found.lower, upper=found.upper)) == pytest.approx(1)


def test_other_up_axes_are_turned_to_y(tmp_path):
    up = (0.0, 0.0, 1.0)
    joint = Joint(JointKind.REVOLUTE, np.array(up), np.array([1.0, 0.0, 0.0]), 0.0, math.pi / 2)
    boxes = [((0, 0, 0), (1, 1, 3)), ((1, 0, 0), (2, 0.1, 3))]
    shape = shape_of_boxes(boxes, (Body(0, "a", (1,)), Body(1, "b", (2,), 0, joint)), up=up)
    found = read_partnet_mobility(write_partnet_mobility(shape, shape.mobility, tmp_path / "7"))
    assert found.mobility.bodies[1].joint.direction == pytest.approx([0, 1, 0])
    low, high = found.bounds
    assert (high - low)[1] == pytest.approx(3)


def test_junk_stays_junk(tmp_path):
    boxes = [((0, 0, 0), (1, 1, 1)), ((1, 0, 0), (2, 1, 1))]
    shape = shape_of_boxes(boxes, (Body(0, "a", (1,)), Body(1, "b", (2,))), junk=frozenset({2}))
    assert read_partnet_mobility(write_partnet_mobility(shape, shape.mobility, tmp_path / "7")).mobility.junk == {2}


def test_a_base_without_parts_is_not_junk(tmp_path):
    joint = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3), 0.0, 1.0)
    shape = shape_of_boxes([((0, 0, 0), (1, 1, 1))], (Body(0, "base", ()), Body(1, "door", (1,), 0, joint)))
    bodies = json.loads((write_partnet_mobility(shape, shape.mobility, tmp_path / "7") / "mobility_v2.json").read_text())
    assert [body["joint"] for body in bodies] == ["heavy", "hinge"]


@pytest.mark.parametrize("kind", list(JointKind))
@pytest.mark.parametrize("size", [1e-3, 1e3])
@pytest.mark.parametrize(("rest", "width"), [(0.0, 0.0), (0.3, 0.0), (0.0, 1e-16)])
def test_a_joint_without_range_does_not_become_unlimited(tmp_path, kind, size, rest, width):
    boxes = [((0, 0, 0), (size, size, size)), ((size, 0, 0), (2 * size, size, size))]
    joint = Joint(kind, np.array([0.0, 1.0, 0.0]), np.zeros(3), rest, rest + width * size, rest)
    shape = shape_of_boxes(boxes, (Body(0, "a", (1,)), Body(1, "b", (2,), 0, joint)))
    found = read_partnet_mobility(write_partnet_mobility(shape, shape.mobility, tmp_path / "7"))
    read = found.mobility.bodies[1].joint
    assert not any("joint" in repair for repair in found.repairs)
    assert read.is_limited and read.lower <= 0.0 <= read.upper
    assert 0.0 < read.upper - read.lower < 1e-5 * (1.0 if kind is JointKind.REVOLUTE else size)
