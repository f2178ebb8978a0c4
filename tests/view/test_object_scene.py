"""Scenes: the joints, poses and colours that viewers show."""

from __future__ import annotations

import base64
import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from cabinet_results import cabinet_prediction
from predicted_cabinet import PIECES
from textured_files import factor_alone

import kinmo
from kinmo.view.object_scene import ObjectScene
from kinmo.view.scene_building import scene_of
from kinmo.view.scene_data import scene_json


@pytest.fixture
def prediction(tmp_path: Path) -> kinmo.Prediction:
    return cabinet_prediction(tmp_path)


def body(scene: ObjectScene, name: str) -> int:
    return next(index for index, each in enumerate(scene.bodies) if each.name == name)


def test_ranked_joints_are_options_and_the_present_one_is_chosen(prediction: kinmo.Prediction) -> None:
    door = scene_of(prediction).bodies[1]
    assert [option.label for option in door.options] == [
        "1. hinge, vertical, right edge 0.40",
        "2. hinge, vertical, left edge 0.30",
        "3. slider, to the front 0.20",
        "4. fixed 0.10",
    ]
    assert door.chosen == 0 and door.key == "door"


def test_a_correction_is_the_first_option(prediction: kinmo.Prediction) -> None:
    corrected = prediction.with_overrides({"bodies": {"door": {"alternative": 2, "name": "left door"}}})
    door = scene_of(corrected).bodies[1]
    assert door.name == "left door" and door.key == "door"
    assert door.options[door.chosen].label == "hinge, vertical, left edge, by hand"
    assert [option.rank for option in door.options] == [None, 1, 2, 3, 4]


def test_bodies_of_one_name_have_different_keys(prediction: kinmo.Prediction) -> None:
    bodies = list(prediction.mobility.bodies)
    bodies[2] = replace(bodies[2], name="door")
    estimate = replace(prediction.estimate, mobility=replace(prediction.mobility, bodies=tuple(bodies)))
    scene = scene_of(replace(prediction, estimate=estimate))
    assert [each.key for each in scene.bodies] == ["base", "#1", "#2", "front"]


def test_unnamed_bodies_are_shown_by_their_number_after_others_are_gone(prediction: kinmo.Prediction) -> None:
    first, door, knob, front = prediction.mobility.bodies
    bodies = (first, replace(front, id=7, name=""), replace(door, id=9, name=""), replace(knob, name="knob", parent=2))
    estimate = replace(prediction.estimate, mobility=replace(prediction.mobility, bodies=bodies))
    unnamed = replace(prediction, estimate=estimate)
    assert [each.name for each in scene_of(unnamed).bodies][:3] == ["base", "#7", "#9"]
    assert {"body_7", "body_9"} <= {link.name for link in unnamed.links}


@pytest.mark.parametrize("front", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), None])
def test_the_front_is_where_parts_open_to(front: tuple[float, float, float] | None, prediction: kinmo.Prediction) -> None:
    shape = replace(prediction.shape, front=front)
    outwards = prediction.with_overrides({"bodies": {"door": {"alternative": 2, "flip": True, "parts": ["door", "knob"]}}})
    assert scene_of(replace(outwards, shape=shape)).front == pytest.approx([0.0, 0.0, 1.0])
    assert scene_of(shape).front == pytest.approx(np.array(front or (0.0, 0.0, 1.0))), "without joints, that of the shape"


@pytest.mark.parametrize("up", [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
def test_poses_agree_with_those_of_the_prediction(up: tuple[float, float, float], prediction: kinmo.Prediction) -> None:
    prediction = replace(prediction, shape=replace(prediction.shape, up=up, front=None))
    scene = scene_of(prediction)
    expected = prediction.articulate({"door": 0.7, "front": 0.1})
    poses = scene.poses({body(scene, "door"): 0.7, body(scene, "front"): 0.1})
    assert scene.rotation @ up == pytest.approx([0.0, 1.0, 0.0])
    for index, each in enumerate(scene.bodies):
        turn = np.eye(4)
        turn[:3, :3] = scene.rotation
        np.testing.assert_allclose(turn.T @ poses[index] @ turn, expected[each.name], atol=1e-12)


def test_values_begin_at_the_pose_of_the_file(prediction: kinmo.Prediction) -> None:
    bodies = list(prediction.mobility.bodies)
    bodies[3] = replace(bodies[3], joint=replace(bodies[3].joint, lower=0.2, upper=0.5, rest=0.3))
    mobility = replace(prediction.mobility, bodies=tuple(bodies))
    scene = scene_of(replace(prediction.shape, mobility=mobility))
    assert scene.range_of(3) == pytest.approx((-0.1, 0.2))
    assert scene.opened(1.0)[3] == pytest.approx(0.2)
    assert scene.opened(0.0)[3] == 0.0


def test_an_axis_runs_along_its_joint_through_its_body(prediction: kinmo.Prediction) -> None:
    scene = scene_of(prediction)
    for index, each in enumerate(scene.bodies):
        if each.joint is None:
            continue
        begin, end = scene.axis_ends(index)
        along = (end - begin) / np.linalg.norm(end - begin)
        assert along == pytest.approx(each.joint.direction)
        low, high = (ends for ends in np.array([scene.meshes[leaf].vertices for leaf in each.leaves]).reshape(-1, 3)[[0, -1]])
        assert (begin @ along) < min(low @ along, high @ along) and (end @ along) > max(low @ along, high @ along)


def test_the_geometry_of_the_data_is_that_of_the_parts(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    scene = scene_of(prediction)
    data = json.loads(scene_json(scene))
    (tmp_path / "scene.glb").write_bytes(gzip.decompress(base64.b64decode(data["glb"])))
    found = trimesh.load_scene(tmp_path / "scene.glb")
    places = {
        name: trimesh.transform_points(found.geometry[name].vertices, pose)
        for pose, name in (found.graph[node] for node in found.graph.nodes_geometry)
    }
    for each, made in zip(scene.bodies, data["bodies"], strict=True):
        for leaf, part in zip(each.leaves, made["parts"], strict=True):
            vertices = places[part["node"]]
            np.testing.assert_allclose(vertices.min(axis=0), scene.meshes[leaf].vertices.min(axis=0), atol=1e-6)
            np.testing.assert_allclose(vertices.max(axis=0), scene.meshes[leaf].vertices.max(axis=0), atol=1e-6)


def test_text_of_a_file_cannot_end_the_script_of_a_page(tmp_path: Path) -> None:
    names = ("</script><script>alert(1)</script>", *tuple(PIECES)[1:])
    text = scene_json(scene_of(cabinet_prediction(tmp_path, names)))
    assert "<" not in text and "alert(1)" in text


def test_a_shape_without_joints_is_one_resting_body(tmp_path: Path) -> None:
    scene = scene_of(cabinet_prediction(tmp_path).shape)
    assert len(scene.bodies) == 1 and scene.bodies[0].joint is None and not scene.bodies[0].options
    assert len(scene.bodies[0].leaves) == len(PIECES)


def test_moving_bodies_have_colours_of_their_own(prediction: kinmo.Prediction) -> None:
    colors = [each.color for each in scene_of(prediction).bodies]
    assert len(set(colors)) == len(colors)


def test_a_plain_file_has_no_looks(prediction: kinmo.Prediction) -> None:
    assert not scene_of(prediction).has_looks


def test_one_colour_for_all_parts_is_a_look_but_not_a_varied_one(tmp_path: Path) -> None:
    scene = scene_of(kinmo.load(factor_alone(tmp_path).path))
    assert scene.has_looks and not scene.has_varied_looks
