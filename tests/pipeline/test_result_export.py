"""Export of one saved prediction with its corrections, in place or elsewhere, and as a part of `kinmo predict`."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cabinet_results import cabinet_prediction, predict_cabinets, result_in
from predicted_cabinet import CORRECTIONS, write_cabinet_glb
from trained_workspace import Recorder, contents

from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import JointKind, joint_from_data
from kinmo.io.readers import read_partnet_mobility
from kinmo.io.readers.urdf_reader import read_robot_file
from kinmo.io.result_folder import read_result
from kinmo.pipeline.export_results import ExportResults
from kinmo.pipeline.result_export import (
    UNCHECKED,
    WITHOUT_CATEGORY,
    ExportedResult,
    ExportJob,
    apply_overrides,
    corrected_result,
    export_result,
)
from kinmo.robot.physics import Physics


def export(folder: Path, target: Path | None = None, **how: Any) -> ExportedResult:
    result = export_result(ExportJob(folder, target or folder, **how))
    assert isinstance(result, ExportedResult), result
    return result


def joints_of(folder: Path) -> dict[str, dict[str, Any]]:
    bodies = json.loads((folder / "joints.json").read_text(encoding="utf-8"))["bodies"]
    return {body["name"]: body["joint"] for body in bodies if body["joint"] is not None}


def test_corrections_are_written_and_twice_gives_the_same_as_once(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    result = export(folder)
    assert result.lines == (
        "  door: hinge, 0 to 110°, corrected by hand",
        "  drawer: slider, 0 to 0.3 m, corrected by hand",
    )
    assert result.notes == ("knob has no part left: dropped",) and result.data["corrected"]
    once = contents(folder)
    export(folder)
    assert contents(folder) == once


def test_the_physics_of_the_result_is_repeated(tmp_path: Path) -> None:
    folder = tmp_path / "heavy"
    physics = Physics(density=600.0, friction=0.7)
    cabinet_prediction(tmp_path).export(folder, ["urdf", "joints_json"], collision="none", physics=physics)
    before = contents(folder)
    export(folder)
    assert contents(folder) == before
    urdf = ElementTree.parse(folder / "heavy.urdf")
    assert {dynamics.get("friction") for dynamics in urdf.iter("dynamics")} == {"0.7"}


def test_without_overrides_the_prediction_is_restored(tmp_path: Path) -> None:
    folder = result_in(tmp_path, None)
    predicted = contents(folder)
    (folder / "overrides.toml").write_text(CORRECTIONS, encoding="utf-8")
    export(folder)
    assert contents(folder) != predicted
    (folder / "overrides.toml").unlink()
    export(folder)
    assert contents(folder) == predicted


def test_the_urdf_has_the_joints_of_joints_json(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    export(folder)
    robot = read_robot_file(folder / "cabinet.urdf", folder)
    joints = joints_of(folder)
    elements = ElementTree.parse(folder / "cabinet.urdf").iterfind("joint")
    limits = {
        each.find("child").get("link"): [float(each.find("limit").get(end)) for end in ("lower", "upper")] for each in elements
    }
    assert set(robot.links) == {"base", *joints}
    rotation = z_up_rotation(np.array([0.0, 1.0, 0.0]))
    for name, data in joints.items():
        joint, written = joint_from_data(data), robot.joint_above[name]
        assert (written.type == "prismatic") == (joint.kind is JointKind.PRISMATIC)
        pose = written.pose  # the parent of each is the base, which lies in the frame of the file
        np.testing.assert_allclose(pose[:3, :3] @ written.axis, rotation @ joint.direction, atol=1e-9)
        if joint.has_pivot:
            off = pose[:3, 3] - rotation @ joint.pivot
            np.testing.assert_allclose(np.cross(off, rotation @ joint.direction), 0.0, atol=1e-9)
        assert limits[name] == pytest.approx((joint.lower, joint.upper))


def test_corrected_objects_are_annotated_shapes(tmp_path: Path) -> None:
    folder, target = result_in(tmp_path), tmp_path / "annotated"
    result = export(folder, target, formats=("partnet_mobility",))
    assert result.notes[-1] == WITHOUT_CATEGORY
    shape = read_partnet_mobility(target)
    corrected = corrected_result(ExportJob(folder, folder))[0].estimate.mobility
    assert shape.mobility is not None
    found, expected = [{body.name: body.joint for _, body in each.movable()} for each in (shape.mobility, corrected)]
    assert found.keys() == expected.keys() == {"door", "drawer"}
    for name, joint in found.items():
        assert joint is not None and expected[name] is not None
        np.testing.assert_allclose(joint.direction, expected[name].direction, atol=1e-9)
        assert (joint.lower, joint.upper) == pytest.approx((expected[name].lower, expected[name].upper))


def test_an_annotation_that_nobody_checked_is_noted(tmp_path: Path) -> None:
    folder = result_in(tmp_path, None)
    assert UNCHECKED in export(folder, tmp_path / "a", formats=("partnet_mobility",)).notes
    (folder / "overrides.toml").touch()
    assert UNCHECKED not in export(folder, tmp_path / "b", formats=("partnet_mobility",)).notes


def test_another_folder_is_a_result_of_its_own(tmp_path: Path) -> None:
    folder, target = result_in(tmp_path), tmp_path / "robots" / "kitchen"
    before = contents(folder)
    export(folder, target)
    assert contents(folder) == before
    assert (target / "kitchen.urdf").is_file()
    assert (target / "overrides.toml").read_text(encoding="utf-8") == CORRECTIONS
    once = contents(target)
    export(target, replaced=tuple(once))
    assert contents(target) == once


def test_formats_are_added_in_place(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    export(folder, formats=("partnet_mobility",))
    assert read_result(folder).options.formats == ("urdf", "joints_json", "partnet_mobility")
    (folder / "overrides.toml").write_text("", encoding="utf-8")
    export(folder)
    assert "pseudo_label" not in (folder / "meta.json").read_text(encoding="utf-8")
    assert len(read_partnet_mobility(folder).mobility.bodies) == 4  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "[bodies.dor]\nflip = true",
            r"bodies.dor: there is no body dor (did you mean door?); there are base, door, knob, front",
        ),
        ("[bodies.door]\nparts = ['lid']", r"bodies.door.parts[0]: there is no part lid; there are "),
        ("[bodies.door]\ncolour = 'red'", r"bodies.door.colour: unknown key; expected one of "),
        ("[bodies.door", r"expected TOML ("),
    ],
)
def test_a_mistake_is_one_line_and_nothing_is_written(tmp_path: Path, text: str, message: str) -> None:
    folder = result_in(tmp_path, text)
    before = contents(tmp_path)
    for target in (folder, tmp_path / "elsewhere"):
        problem = export_result(ExportJob(folder, target, ("urdf", "joints_json", "partnet_mobility")))
        assert isinstance(problem, str) and problem.startswith(f"{folder / 'overrides.toml'}: {message}")
        assert "\n" not in problem
    assert contents(tmp_path) == before


def test_a_target_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    (tmp_path / "file").touch()
    problem = export_result(ExportJob(folder, tmp_path / "file" / "cabinet"))
    assert isinstance(problem, str) and "file" in problem and "\n" not in problem


def test_predict_applies_overrides_that_are_new_changed_or_gone(tmp_path: Path) -> None:
    folder = result_in(tmp_path, None)
    predicted = contents(folder)
    for text, joints in ((CORRECTIONS, {"door", "drawer"}), ("[bodies.knob]\nname = 'pull'", {"door", "pull", "front"})):
        (folder / "overrides.toml").write_text(text, encoding="utf-8")
        outcome = predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out")
        assert outcome.failed == 0 and set(joints_of(folder)) == joints
        assert "corrected by hand" in outcome.text or "pull" in outcome.text
    assert apply_overrides([folder], Recorder()) == {}
    (folder / "overrides.toml").unlink()
    predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out")
    assert contents(folder) == predicted


def test_predict_keeps_overrides_when_the_shape_has_changed(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    assert ExportResults(folder).run(Recorder()).failed == 0
    write_cabinet_glb(tmp_path / "cabinet.glb", ("frame", "door", "handle", "front", "box"))
    assert isinstance(export_result(ExportJob(folder, folder)), str)
    outcome = predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out")
    (problem,) = outcome.data["uncorrected"]
    assert problem.startswith(f"{folder / 'overrides.toml'}: bodies.door.parts[1]: there is no part knob")
    assert outcome.failed == 1 and (folder / "overrides.toml").read_text(encoding="utf-8") == CORRECTIONS
    (folder / "overrides.toml").write_text(CORRECTIONS.replace("knob", "handle"), encoding="utf-8")
    assert predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out").failed == 0
    assert set(joints_of(folder)) == {"door", "drawer"}
