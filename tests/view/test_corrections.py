"""Corrections made in a viewer are those that a person would write by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from cabinet_results import cabinet_prediction, result_in

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.view.corrections import BACKUP_FILE, Corrections

BY_HAND = """# the door
[bodies."#1"]
range = [0, 30]
"""


def joint_named(prediction: kinmo.Prediction, name: str) -> kinmo.Joint:
    return next(each.joint for each in prediction.joints if each.name == name)


def test_saved_corrections_are_what_was_shown(tmp_path: Path) -> None:
    result = result_in(tmp_path, None)
    corrections = Corrections.of(kinmo.Prediction.load(result), result)
    corrections.choose("door", 2)
    corrections.set_range("door", 0.0, 80.0)
    corrections.set_name("door", "left_door")
    corrections.set_type("knob", "fixed")
    corrections.flip("front")
    message = corrections.save()
    assert "kinmo export" in message
    again = kinmo.Prediction.load(result).with_overrides(result / OVERRIDES_FILE)
    assert [joint.name for joint in again.joints] == ["left_door", "front"]
    door = joint_named(again, "left_door")
    assert door.pivot[0] == pytest.approx(-0.39) and door.upper == pytest.approx(math.radians(80.0))
    assert joint_named(again, "front").direction == pytest.approx([0.0, 0.0, -1.0])
    for one, other in zip(again.joints, corrections.prediction.joints, strict=True):
        assert one.joint.direction == pytest.approx(other.joint.direction)


def test_a_new_choice_replaces_what_was_said_about_the_joint(tmp_path: Path) -> None:
    corrections = Corrections.of(cabinet_prediction(tmp_path))
    corrections.set_range("door", 0.0, 10.0)
    corrections.set_name("door", "lid")
    corrections.choose("door", 3)
    assert corrections.entry("door") == {"name": "lid", "alternative": 3}
    assert joint_named(corrections.prediction, "lid").kind is JointKind.PRISMATIC


def test_turning_around_twice_changes_nothing(tmp_path: Path) -> None:
    corrections = Corrections.of(cabinet_prediction(tmp_path))
    corrections.flip("door")
    corrections.flip("door")
    assert corrections.table == {} and corrections.text == ""


def test_resetting_gives_the_predicted_joint(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    corrections = Corrections.of(prediction)
    corrections.choose("door", 2)
    corrections.reset("door")
    assert joint_named(corrections.prediction, "door").pivot == pytest.approx(joint_named(prediction, "door").pivot)


def test_resetting_keeps_the_parts_and_the_parent_of_a_body(tmp_path: Path) -> None:
    corrections = Corrections.of(cabinet_prediction(tmp_path).with_overrides({"bodies": {"door": {"parts": ["door", "knob"]}}}))
    corrections.set_name("door", "flap")
    corrections.flip("door")
    corrections.reset("door")
    assert corrections.table == {"bodies": {"door": {"parts": ["door", "knob"]}}}


def test_a_wrong_change_changes_nothing(tmp_path: Path) -> None:
    corrections = Corrections.of(cabinet_prediction(tmp_path))
    corrections.choose("door", 2)
    before = corrections.prediction
    with pytest.raises(InputError, match="range that contains 0"):
        corrections.set_range("door", 5.0, 10.0)
    assert corrections.prediction is before and corrections.entry("door") == {"alternative": 2}


def test_a_file_by_hand_is_continued_and_kept(tmp_path: Path) -> None:
    result = result_in(tmp_path, BY_HAND)
    corrections = Corrections.of(kinmo.Prediction.load(result), result)
    assert joint_named(corrections.prediction, "door").upper == pytest.approx(math.radians(30.0))
    corrections.set_name("door", "lid")
    assert BACKUP_FILE in corrections.save()
    assert corrections.table == {"bodies": {"#1": {"range": [0, 30], "name": "lid"}}}
    assert (result / BACKUP_FILE).read_text(encoding="utf-8") == BY_HAND
    assert BACKUP_FILE not in corrections.save()


def test_a_file_that_somebody_else_changed_stays(tmp_path: Path) -> None:
    result = result_in(tmp_path, None)
    corrections = Corrections.of(kinmo.Prediction.load(result), result)
    corrections.flip("door")
    (result / OVERRIDES_FILE).write_text(BY_HAND, encoding="utf-8")
    with pytest.raises(InputError, match="somebody else"):
        corrections.save()
    assert (result / OVERRIDES_FILE).read_text(encoding="utf-8") == BY_HAND


def test_a_prediction_without_a_folder_is_not_saved(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"Prediction\.save"):
        Corrections.of(cabinet_prediction(tmp_path)).save()
