"""URDF folders of generated objects as annotated shapes."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from articulated import box_mesh

import mobility_from_urdf
import urdf_objects
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.io.readers import read_partnet_mobility

FACTS = {"category": "Refrigerator", "up": "z", "front": "-y", "generator": "hand", "licence": "CC0", "seed": 3}


def piece(name, low, high) -> urdf_objects.Piece:
    mesh = box_mesh(low, high)
    return urdf_objects.Piece(name, mesh.vertices, mesh.faces)


def cabinet() -> urdf_objects.UrdfObject:
    """A carcass of two boards, a door with a handle that is a link of its own, and a drawer. The front is at -y."""
    links = {
        "frame": [piece("back", (0, 1, 0), (1, 1.1, 2)), piece("side", (-0.1, 0, 0), (0, 1, 2))],
        "door": [piece("panel", (0, -0.1, 0), (1, 0, 1))],
        "knob": [piece("knob", (-0.05, -0.05, -0.05), (0.05, 0.05, 0.05))],
        "drawer": [piece("front", (0, -0.1, 1), (1, 0, 2))],
    }
    joints = [
        urdf_objects.Connection("hinge", "revolute", "frame", "door", (0.0, 0.0, 0.0), axis=(0, 0, -1), limits=(0.0, 1.5)),
        urdf_objects.Connection("glue", "fixed", "door", "knob", (0.9, -0.15, 0.5)),
        urdf_objects.Connection("slide", "prismatic", "frame", "drawer", axis=(0, -1, 0), limits=(0.0, 0.7)),
    ]
    return urdf_objects.UrdfObject(links, joints, FACTS)


def read(folder, made=None):
    urdf_objects.write_urdf_object(folder, made or cabinet())
    return mobility_from_urdf.read_urdf_object(folder)[0]


def test_pieces_are_named_leaves_below_their_bodies(tmp_path):
    shape = read(tmp_path / "cabinet-0001")
    names = [[shape.parts[leaf].name for leaf in body.leaves] for body in shape.mobility.bodies]
    assert names == [["back", "side"], ["panel", "knob"], ["front"]]
    assert [shape.parts[i].name for i in shape.parts[0].children] == ["frame", "door", "drawer"]


def test_shapes_are_y_up_with_the_front_at_z(tmp_path):
    shape = read(tmp_path / "cabinet-0001")
    assert shape.up == (0, 1, 0) and shape.front == (0, 0, 1)
    door, drawer = (body.joint for _, body in shape.mobility.movable())
    np.testing.assert_allclose(door.direction, (0, -1, 0), atol=1e-12)
    np.testing.assert_allclose(drawer.direction, (0, 0, 1), atol=1e-12)
    assert (door.kind, door.lower, door.upper) == (JointKind.REVOLUTE, 0.0, 1.5)
    np.testing.assert_allclose(np.ptp(shape.bounds, axis=0), (1.1, 2.0, 1.3), atol=1e-12)


def test_equal_corners_are_one_vertex(tmp_path):
    shape = read(tmp_path / "cabinet-0001")
    assert {len(mesh.vertices) for mesh in shape.meshes()} == {8}


def test_the_written_truth_reads_back(tmp_path):
    urdf_objects.write_urdf_object(tmp_path / "cabinet-0001", cabinet())
    written = mobility_from_urdf.write_truth(tmp_path / "cabinet-0001", tmp_path / "out" / "cabinet-0001")
    again = read_partnet_mobility(tmp_path / "out" / "cabinet-0001")
    assert again.category == "Refrigerator" and not again.repairs
    assert [body.leaves for body in again.mobility.bodies] == [body.leaves for body in written.mobility.bodies]
    for (_, one), (_, other) in zip(written.mobility.movable(), again.mobility.movable(), strict=True):
        assert one.joint.kind is other.joint.kind
        np.testing.assert_allclose(one.joint.direction, other.joint.direction, atol=1e-12)
        np.testing.assert_allclose((one.joint.lower, one.joint.upper), (other.joint.lower, other.joint.upper))
    meta = json.loads((tmp_path / "out" / "cabinet-0001" / "meta.json").read_text())
    assert (meta["generator"], meta["licence"], meta["seed"]) == ("hand", "CC0", 3)


def test_an_unknown_front_is_refused(tmp_path):
    made = replace(cabinet(), facts=FACTS | {"front": "south"})
    with pytest.raises(InputError, match="front"):
        read(tmp_path / "cabinet-0001", made)


def test_a_joint_of_another_kind_is_refused(tmp_path):
    loose = urdf_objects.Connection("free", "floating", "frame", "drawer")
    made = replace(cabinet(), joints=[*cabinet().joints[:2], loose])
    with pytest.raises(InputError, match="drawer"):
        read(tmp_path / "cabinet-0001", made)
