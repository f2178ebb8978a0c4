"""Corrections by hand in the Python API: load, correct, save, export."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cabinet_results import cabinet_prediction, predict_cabinets, result_in
from predicted_cabinet import CORRECTIONS, LEFT, RIGHT, UP, write_cabinet_glb
from trained_workspace import Recorder, contents

import kinmo
from kinmo.core.joint import joint_to_data
from kinmo.core.toml_text import parse_toml
from kinmo.pipeline.export_results import ExportResults

TABLE = parse_toml(CORRECTIONS.encode(), Path("overrides.toml"))


def facts(prediction: kinmo.Prediction) -> list[tuple[Any, ...]]:
    """All about the joints of a prediction, as plain data."""
    return [
        (
            *(joint.name, joint.parent, joint.parts, joint.score, joint.is_corrected, joint_to_data(joint.joint)),
            [(joint_to_data(other), score) for other, score in joint.alternatives],
        )
        for joint in prediction.joints
    ]


@pytest.mark.parametrize("overrides", [None, {}, TABLE], ids=["predicted", "checked", "corrected"])
def test_what_is_saved_is_loaded(tmp_path: Path, overrides: dict[str, Any] | None) -> None:
    prediction = cabinet_prediction(tmp_path)
    if overrides is not None:
        prediction = prediction.with_overrides(overrides)
    prediction.save(tmp_path / "saved")
    prediction.export(tmp_path / "exported", ["joints_json", "urdf"], metres_per_unit=0.01)
    for folder in ("saved", "exported"):
        loaded = kinmo.Prediction.load(tmp_path / folder)
        assert facts(loaded) == facts(prediction) and loaded.provenance == prediction.provenance
        assert (tmp_path / folder / "overrides.toml").is_file() == (overrides is not None)
    assert loaded.shape.metres_per_unit == 0.01


def test_corrections_are_those_of_the_file(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    (tmp_path / "overrides.toml").write_text(CORRECTIONS, encoding="utf-8")
    corrected = prediction.with_overrides(tmp_path / "overrides.toml")
    assert facts(corrected) == facts(prediction.with_overrides(str(tmp_path / "overrides.toml")))
    assert facts(corrected) == facts(prediction.with_overrides(TABLE))
    assert [(joint.name, joint.is_corrected, joint.score) for joint in corrected.joints] == [
        ("door", True, 1.0),
        ("drawer", True, 1.0),
    ]
    door = corrected.joints[0]
    np.testing.assert_allclose(door.joint.direction, -UP)
    np.testing.assert_allclose(door.joint.pivot, LEFT)
    pose = corrected.articulate({"door": 0.5})["door"]
    assert (pose @ [*RIGHT, 1.0])[2] > RIGHT[2] + 0.1, "the free edge moves out of the cabinet"


def test_corrections_replace_earlier_ones(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    corrected = prediction.with_overrides(TABLE)
    assert facts(corrected.with_overrides(TABLE)) == facts(corrected)
    flipped = {"bodies": {"knob": {"flip": True}}}
    assert facts(corrected.with_overrides(flipped)) == facts(prediction.with_overrides(flipped))
    assert facts(corrected.with_overrides({})) == facts(prediction)
    assert prediction.estimate.correction is None, "the prediction itself stays"


def test_the_api_corrects_as_the_command_line_does(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    predicted = kinmo.Prediction.load(folder)
    ExportResults(folder).run(Recorder())
    assert facts(kinmo.Prediction.load(folder)) == facts(predicted.with_overrides(folder / "overrides.toml"))


def test_a_result_of_predict_can_be_corrected_in_python(tmp_path: Path) -> None:
    folder = result_in(tmp_path, None)
    corrected = kinmo.Prediction.load(folder).with_overrides(TABLE)
    corrected.save(folder)
    outcome = ExportResults(folder).run(Recorder())
    assert outcome.data["skipped"] == [] and outcome.data["results"][0]["corrected"]
    assert "110" in outcome.text and (folder / "cabinet.urdf").is_file()
    exported = contents(folder)
    corrected.export(folder, ["urdf", "joints_json"], overwrite=True)
    assert ExportResults(folder).run(Recorder()).failed == 0
    assert contents(folder) == exported
    assert predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out").failed == 0
    assert contents(folder) == exported


def test_saving_keeps_what_a_person_edited(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    urdf = folder / "cabinet.urdf"
    urdf.write_text("mine", encoding="utf-8")
    kinmo.Prediction.load(folder).save(folder)
    assert (folder / "overrides.toml").read_text(encoding="utf-8") == CORRECTIONS
    (problem,) = ExportResults(folder).run(Recorder()).data["skipped"]
    assert problem.startswith(f"{urdf}: was edited") and urdf.read_text(encoding="utf-8") == "mine"


def test_comments_in_overrides_stay_while_the_content_does(tmp_path: Path) -> None:
    file = tmp_path / "saved" / "overrides.toml"
    prediction = cabinet_prediction(tmp_path)
    prediction.save(file.parent)
    file.write_text(f"# measured\n{CORRECTIONS}", encoding="utf-8")
    prediction.with_overrides(file).save(file.parent)
    assert file.read_text(encoding="utf-8").startswith("# measured")
    prediction.with_overrides({"bodies": {"door": {"flip": True}}}).save(file.parent)
    assert file.read_text(encoding="utf-8") == "[bodies.door]\nflip = true\n"


def test_exported_annotations_are_marked_unless_corrected(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    for name, each, marked in (("a", prediction, True), ("b", prediction.with_overrides({}), False)):
        each.export(tmp_path / name, ["partnet_mobility"])
        assert ("pseudo_label" in json.loads((tmp_path / name / "meta.json").read_text(encoding="utf-8"))) == marked


def test_a_moved_shape_is_named_by_source(tmp_path: Path) -> None:
    cabinet_prediction(tmp_path).save(tmp_path / "saved")
    moved = (tmp_path / "cabinet.glb").rename(tmp_path / "moved.glb")
    with pytest.raises(kinmo.InputError, match=r"cabinet\.glb: missing: name the file of the shape by --source"):
        kinmo.Prediction.load(tmp_path / "saved")
    assert kinmo.Prediction.load(str(tmp_path / "saved"), source=str(moved)).shape.source == moved
    write_cabinet_glb(moved, ("frame", "lid", "knob", "front", "box"))
    with pytest.raises(kinmo.InputError, match=r"moved\.glb: has changed since the prediction"):
        kinmo.Prediction.load(tmp_path / "saved", source=moved)


def test_what_cannot_be_loaded_or_corrected_is_one_line(tmp_path: Path) -> None:
    prediction = cabinet_prediction(tmp_path)
    with pytest.raises(kinmo.InputError, match=r"nowhere/joints\.json: missing"):
        kinmo.Prediction.load(tmp_path / "nowhere")
    overrides: Any
    for overrides, message in (
        (tmp_path / "no.toml", r"no\.toml: missing$"),
        (
            {"bodies": {"dor": {}}},
            r"^overrides: bodies\.dor: there is no body dor \(did you mean door\?\); there are base, door",
        ),
        ({"bodies": {"door": {"range": (0.0, np.inf)}}}, r"^overrides: bodies\.door\.range\[1\]: expected a finite number$"),
        ({"bodies": {"door": {"axis": np.eye(3)}}}, r"^overrides: bodies\.door\.axis\[0\]: expected a number$"),
        ({"bodies": [1]}, r"^overrides: bodies: expected tables \[bodies\.NAME\]$"),
    ):
        with pytest.raises(kinmo.InputError, match=message):
            prediction.with_overrides(overrides)
