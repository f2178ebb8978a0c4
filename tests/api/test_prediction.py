"""Prediction of a shape by the Python API: joints, poses, and export in every format."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from trained_workspace import METHODS, Recorder, Trained

import kinmo
from kinmo.core.frames import y_up_rotation, z_up_rotation
from kinmo.core.kinematics import forward, joint_motion
from kinmo.core.names import unique_names
from kinmo.io.readers import read_partnet_mobility
from kinmo.io.readers.joints_json_reader import read_joints_json
from kinmo.io.readers.urdf_reader import RobotFile, read_robot_file
from kinmo.io.writers import WRITERS
from kinmo.pipeline.predict_shapes import PredictShapes


@pytest.fixture(scope="module")
def prediction(trained: Trained) -> Iterator[kinmo.Prediction]:
    """The prediction with most joints among some shapes."""
    predictor = kinmo.Predictor(trained.workspace.path, device="cpu")
    shapes = [kinmo.load(path) for path in sorted((trained.shapes / "partnet").iterdir())[:4]]
    yield max((predictor.predict(shape) for shape in shapes), key=lambda found: len(found.joints))


def some_values(prediction: kinmo.Prediction) -> dict[str, float]:
    """A value for every joint that differs from its rest value."""
    return {joint.name: joint.joint.rest + 0.1 + 0.05 * place for place, joint in enumerate(prediction.joints)}


def test_joints_describe_the_mobility(prediction: kinmo.Prediction) -> None:
    assert prediction.joints
    bodies = [body for _, body in prediction.mobility.movable()]
    assert sorted(map(id, (joint.joint for joint in prediction.joints))) == sorted(id(body.joint) for body in bodies)
    names = [joint.name for joint in prediction.joints]
    assert names == unique_names(names)
    for joint in prediction.joints:
        assert joint.parent in {"base", *names} - {joint.name}
        assert 0.0 <= joint.score <= 1.0
        assert all(0.0 <= score <= 1.0 for _, score in joint.alternatives)
        assert joint.parts and all(prediction.shape.parts[part].is_leaf for part in joint.parts)
    assert str(len(names)) in repr(prediction)


def test_every_leaf_belongs_to_one_link(prediction: kinmo.Prediction) -> None:
    leaves = [leaf for link in prediction.links for leaf in link.leaves]
    assert sorted(leaves) == list(prediction.shape.leaves)


def test_poses_are_those_of_forward_kinematics(prediction: kinmo.Prediction) -> None:
    values = some_values(prediction)
    poses = prediction.articulate(values)
    bodies = {link.name: link.body for link in prediction.links if link.body is not None}
    expected = forward(prediction.mobility, {bodies[name]: value for name, value in values.items()})
    for name, body in bodies.items():
        np.testing.assert_array_equal(poses[name], expected[body])
    np.testing.assert_array_equal(poses["base"], np.eye(4))


def test_a_joint_without_a_value_stays(prediction: kinmo.Prediction) -> None:
    for pose in prediction.articulate({}).values():
        np.testing.assert_allclose(pose, np.eye(4), atol=1e-12)
    first = next(joint for joint in prediction.joints if joint.parent == "base")
    moved = prediction.articulate({first.name: first.joint.rest + 0.2})
    np.testing.assert_allclose(moved[first.name], joint_motion(first.joint, first.joint.rest + 0.2), atol=1e-12)


def test_an_unknown_joint_is_named_with_the_known_ones(prediction: kinmo.Prediction) -> None:
    name = prediction.joints[0].name
    for call in (prediction.articulate, prediction.articulated):
        with pytest.raises(kinmo.InputError, match=rf"values: expected names of joints, got {name}x \(did you mean {name}\?\)"):
            call({f"{name}x": 0.0})


def test_articulated_moves_the_meshes(prediction: kinmo.Prediction) -> None:
    values = some_values(prediction)
    poses, moved = prediction.articulate(values), prediction.articulated(values)
    assert moved.mobility is None and moved.id == prediction.shape.id
    for link in prediction.links:
        for leaf in link.leaves:
            before, after = prediction.shape.leaf_mesh(leaf), moved.leaf_mesh(leaf)
            ones = np.column_stack([before.vertices, np.ones(len(before.vertices))])
            np.testing.assert_allclose(after.vertices, (ones @ poses[link.name].T)[:, :3], atol=1e-12)
            np.testing.assert_array_equal(after.faces, before.faces)


def test_a_moved_shape_can_be_exported_again(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    moved = prediction.articulated(some_values(prediction))
    again = kinmo.Prediction(moved, prediction.estimate, prediction.provenance)
    assert again.export(tmp_path / "moved")["urdf"].is_file()


@pytest.mark.parametrize("metres_per_unit", [1.0, 0.01])
def test_the_urdf_moves_like_the_prediction(prediction: kinmo.Prediction, metres_per_unit: float, tmp_path: Path) -> None:
    path = prediction.export(tmp_path / "model", ["urdf"], metres_per_unit=metres_per_unit)["urdf"]
    assert path == tmp_path / "model" / "model.urdf"
    robot = read_robot_file(path, tmp_path)
    rotation = np.eye(4)
    rotation[:3, :3] = metres_per_unit * z_up_rotation(np.asarray(prediction.shape.up, float))
    values = some_values(prediction)
    still, moved = urdf_poses(robot, {}, metres_per_unit), urdf_poses(robot, urdf_values(prediction, values), metres_per_unit)
    for name, pose in prediction.articulate(values).items():
        motion = moved[name] @ np.linalg.inv(still[name])
        np.testing.assert_allclose(motion, rotation @ pose @ np.linalg.inv(rotation), atol=1e-6)


def urdf_values(prediction: kinmo.Prediction, values: dict[str, float]) -> dict[str, float]:
    """Joint values as URDF counts them: 0 where the file shows the parts."""
    return {joint.name: values[joint.name] - joint.joint.rest for joint in prediction.joints}


def urdf_poses(robot: RobotFile, values: dict[str, float], metres_per_unit: float) -> dict[str, np.ndarray]:
    """Pose [4, 4] of every link of a URDF at joint values (radians, and lengths of the shape)."""
    poses = {robot.links[0]: np.eye(4)}
    for name in robot.links[1:]:
        joint = robot.joint_above[name]
        value = values.get(name.removesuffix("-slide"), 0.0)
        kind = kinmo.JointKind.PRISMATIC if joint.type == "prismatic" else kinmo.JointKind.REVOLUTE
        if kind is kinmo.JointKind.PRISMATIC:
            value *= metres_per_unit
        elif f"{name}-slide" in robot.links:  # the rotation of a screw
            value = 0.0
        motion = joint_motion(kinmo.Joint(kind, joint.axis, np.zeros(3)), value)
        poses[name] = poses[joint.parent] @ joint.pose @ motion
    return poses


@pytest.mark.parametrize("name", sorted(WRITERS))
def test_every_format_can_be_exported(name: str, prediction: kinmo.Prediction, tmp_path: Path) -> None:
    written = prediction.export(tmp_path / "cabinet", [name])
    assert written.keys() == {name}
    assert written[name].exists() and written[name].is_relative_to(tmp_path / "cabinet")


def test_several_formats_go_into_one_folder_and_can_be_read_back(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    written = prediction.export(tmp_path / "cabinet", ["urdf", "joints_json", "partnet_mobility"])
    assert len({path if path.is_dir() else path.parent for path in written.values()}) == 1
    estimate, provenance = read_joints_json(written["joints_json"], prediction.shape)
    assert provenance.weights == prediction.provenance.weights
    annotated = read_partnet_mobility(tmp_path / "cabinet").mobility
    assert annotated is not None
    count = len(list(prediction.mobility.movable()))
    assert len(list(estimate.mobility.movable())) == len(list(annotated.movable())) == count


def test_a_folder_with_files_is_replaced_only_on_request(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(kinmo.InputError, match="has files in it: name another folder, or pass overwrite=True"):
        prediction.export(tmp_path)
    assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine"
    for _ in range(2):
        prediction.export(tmp_path / "cabinet", overwrite=True)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"formats": ["urfd"]}, r"formats: unknown format urfd \(did you mean urdf\?\)"),
        ({"collision": "Convex"}, r"collision: expected one of .*, got Convex \(did you mean convex\?\)"),
        ({"metres_per_unit": 0.0}, "metres_per_unit: expected a positive number, got 0.0"),
        ({"metres_per_unit": float("inf")}, "metres_per_unit: expected a positive number, got inf"),
    ],
)
def test_wrong_options_of_an_export_are_named(
    options: dict[str, object], message: str, prediction: kinmo.Prediction, tmp_path: Path
) -> None:
    with pytest.raises(kinmo.InputError, match=message):
        prediction.export(tmp_path / "cabinet", **options)  # type: ignore[arg-type]
    assert not (tmp_path / "cabinet").exists()


def test_the_model_is_named_after_the_folder_or_as_asked(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    assert prediction.export(tmp_path / "cabinet")["urdf"].name == "cabinet.urdf"
    assert prediction.export(tmp_path / "other", name="model")["urdf"].name == "model.urdf"
    with pytest.raises(kinmo.InputError, match=r"^name: expected a file name without folders, got \.\./model"):
        prediction.export(tmp_path / "third", name="../model")


def test_the_current_folder_cannot_be_replaced(
    prediction: kinmo.Prediction, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in (".", tmp_path):
        with pytest.raises(kinmo.InputError, match="is the current folder"):
            prediction.export(folder, overwrite=True)


def test_save_writes_joints_json_beside_other_files(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "notes.txt").touch()
    path = prediction.save(tmp_path / "new")
    assert path == tmp_path / "new" / "joints.json"
    assert sorted(each.name for each in path.parent.iterdir()) == ["joints.json", "notes.txt"]
    document = json.loads(path.read_text(encoding="utf-8"))
    assert sum(body["joint"] is not None for body in document["bodies"]) == len(prediction.joints)
    assert prediction.save(tmp_path / "deep" / "folder").is_file()


def test_save_keeps_the_settings_of_the_export(prediction: kinmo.Prediction, tmp_path: Path) -> None:
    folder = tmp_path / "cabinet"
    prediction.export(folder, ["urdf", "joints_json"], collision="hull", package="cabinet")
    settings = json.loads((folder / "joints.json").read_text(encoding="utf-8"))["export"]
    prediction.save(folder)
    assert json.loads((folder / "joints.json").read_text(encoding="utf-8"))["export"] == settings
    assert (settings["collision"], settings["package"]) == ("hull", "cabinet")


@pytest.mark.parametrize("method", METHODS)
def test_the_api_predicts_what_the_command_line_predicts(method: str, trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    PredictShapes([source], tmp_path / "out", trained.workspace, method, device="cpu").run(Recorder())
    prediction = kinmo.Predictor(trained.workspace.path, method=method, device="cpu").predict(kinmo.load(source))
    written = json.loads((tmp_path / "out" / source.name / "joints.json").read_text(encoding="utf-8"))
    saved = json.loads(prediction.save(tmp_path / "api").read_text(encoding="utf-8"))
    assert saved["bodies"] == written["bodies"]
    assert saved["method"] == written["method"]


def test_a_prediction_does_not_depend_on_the_frame(trained: Trained, prediction: kinmo.Prediction) -> None:
    rotation = y_up_rotation(np.array([0.0, 0.0, 1.0])).T  # to z up, and the front at -y
    again = kinmo.Predictor(trained.workspace.path, device="cpu").predict(prediction.shape.rotated(rotation))
    assert [joint.name for joint in again.joints] == [joint.name for joint in prediction.joints]
    for one, other in zip(again.joints, prediction.joints, strict=True):
        assert one.joint.direction == pytest.approx(rotation @ other.joint.direction, abs=1e-9)
        assert one.score == pytest.approx(other.score)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"workspace": "nowhere", "method": "paper"}, "there is no such workspace"),
        ({"method": "magic"}, "expected one of kinmo, paper, got magic"),
    ],
)
def test_a_predictor_without_networks_names_the_remedy(
    options: dict[str, str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kinmo.InputError, match=message):
        kinmo.Predictor(**options)
    assert not list(tmp_path.iterdir())


def test_load_reads_one_shape(trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    shape = kinmo.load(source)
    assert shape.id == source.name and shape.parts and shape.up == (0.0, 1.0, 0.0)
    assert kinmo.load(str(source), up="z").up == (0.0, 0.0, 1.0)
    with pytest.raises(kinmo.InputError, match=r"expected one shape: found \d+ shapes, the first at"):
        kinmo.load(trained.shapes)
    with pytest.raises(kinmo.InputError, match="expected one shape: found no shape"):
        kinmo.load(tmp_path)
    with pytest.raises(kinmo.InputError, match="no such file"):
        kinmo.load(tmp_path / "nowhere")


def test_load_stops_at_a_shape_that_cannot_be_read(trained: Trained, tmp_path: Path) -> None:
    source = sorted((trained.shapes / "partnet").iterdir())[0]
    shutil.copytree(source, tmp_path / "bad")
    (tmp_path / "bad" / "result.json").write_text("[{", encoding="utf-8")
    with pytest.raises(kinmo.InputError, match=r"result\.json"):
        kinmo.load(tmp_path / "bad")
