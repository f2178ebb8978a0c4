"""Where what is predicted goes, and what is told of shapes for which that fails."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from datasets import write_partnet, write_partnet_mobility
from trained_workspace import Recorder

from kinmo import _core
from kinmo.core.errors import InputError
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.names import MAX_NAME_BYTES
from kinmo.core.prediction import JointEstimate, ShapeEstimate
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.writers import WRITERS, write_urdf
from kinmo.pipeline import predict_shapes as predict
from kinmo.pipeline.predict_shapes import Predict

SHELF, DOOR = "棚", "扉"
"""Three bytes each."""


@dataclass(frozen=True)
class Stiff:
    """Says of every shape that nothing moves."""

    method: str = "none"
    weights: str = ""
    config: Mapping[str, Any] = field(default_factory=dict)

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        still, bodies = JointEstimate(None, MotionType.NONE, 1.0), (Body(0, "base", shape.leaves),)
        return ShapeEstimate(shape.id, shape.category, Mobility(bodies), ((still,),), (still,), self.method)


@pytest.fixture
def stage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Predict:
    monkeypatch.setattr(predict, "load_predictor", lambda *_: Stiff())
    return Predict(tmp_path / "shapes", tmp_path / "out", Workspace(tmp_path / "workspace"), "none", device="cpu")


def test_names_too_long_for_a_folder_are_cut_and_told_apart(stage: Predict) -> None:
    deep = stage.source / (SHELF * 80) / (SHELF * 80) / (SHELF * 80)
    for place in (deep / DOOR / "scene", deep / f"{DOOR}{DOOR}" / "scene", stage.source / (DOOR * 84), stage.source / "door"):
        write_partnet(place)
    outcome = stage.run(Recorder())
    assert outcome.data["left_out"] == []
    folders = [Path(shape["folder"]) for shape in outcome.data["shapes"]]
    assert {path.name for path in stage.out.iterdir() if path.name != ".lock"} == {folder.name for folder in folders}
    assert sorted(folder.name.split("~")[0] for folder in folders) == ["door", DOOR * 50, SHELF * 50, SHELF * 50]
    assert all((folder / f"{folder.name}.urdf").is_file() for folder in folders)
    assert stage.plan().steps == (), "it is done"


def test_what_cannot_be_looked_at_is_told(stage: Predict, tmp_path: Path) -> None:
    write_partnet(stage.source / "door")
    (tmp_path / "elsewhere").mkdir()
    (stage.source / "link").symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    told = Recorder()
    outcome = stage.run(told)
    assert outcome.failed == len(outcome.data["left_out"]) == 1
    assert [note for note in told.notes if note == f"left out: {outcome.data['left_out'][0]}"]


@pytest.mark.parametrize("name", ["d" * MAX_NAME_BYTES, DOOR * (MAX_NAME_BYTES // 3), "Tür"])
def test_names_that_fit_stay_as_they_are(stage: Predict, name: str) -> None:
    write_partnet(stage.source / name)
    assert [Path(shape["folder"]).name for shape in stage.run(Recorder()).data["shapes"]] == [name]


def test_a_result_that_cannot_be_written_is_its_shape_s_problem(stage: Predict, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(shape: Any, prediction: Any, folder: Path, options: Any) -> Path:
        if shape.id == "b":
            raise OSError(28, os.strerror(28), str(folder / "b.urdf"))
        return write_urdf(shape, prediction, folder, options)

    monkeypatch.setitem(WRITERS, "urdf", full)
    for name in "abc":
        write_partnet(stage.source / name)
    told = Recorder()
    outcome = stage.run(told)
    assert [shape["id"] for shape in outcome.data["shapes"]] == ["a", "c"]
    (line,) = outcome.data["left_out"]
    assert line.startswith(f"{stage.source / 'b'}: ") and "b.urdf: No space left on device" in line
    assert told.notes == [f"left out: {line}"] and outcome.failed == 1
    assert not (stage.out / "b").exists()


def test_a_shape_that_nobody_foresaw_does_not_keep_others_from_being_predicted(
    stage: Predict, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unforeseen(shape: Any, **how: Any) -> PreparedShape:
        if shape.id == "b":
            raise RuntimeError("no such axis")
        return prepare_shape(shape, **how)

    monkeypatch.setattr(predict, "prepare_shape", unforeseen)
    for name in "abc":
        write_partnet(stage.source / name)
    outcome = stage.run(Recorder())
    assert [shape["id"] for shape in outcome.data["shapes"]] == ["a", "c"]
    (line,) = outcome.data["left_out"]
    assert line.startswith(f"{stage.source / 'b'}: cannot be predicted: RuntimeError at test_predict.py:")
    assert line.endswith(": no such axis") and outcome.failed == 1


def test_what_was_predicted_of_another_shape_stays(stage: Predict) -> None:
    for place in ("a", "b"):
        write_partnet(stage.source / place / "cabinet")
    assert replace(stage, source=stage.source / "a").run(Recorder()).failed == 0
    outcome = replace(stage, source=stage.source / "b").run(Recorder())
    (line,) = outcome.data["left_out"]
    assert line == (
        f"{stage.out / 'cabinet'}: is in the way: it has what was predicted of {stage.source / 'a' / 'cabinet'}; "
        "name another folder by --out"
    )
    assert predict._source(stage.out / "cabinet") == str(stage.source / "a" / "cabinet")


@pytest.mark.parametrize("damaged", ["door.urdf", "joints.json", "meshes", "half of joints.json"])
def test_a_result_that_is_not_whole_is_made_anew(stage: Predict, damaged: str) -> None:
    write_partnet(stage.source / "door")
    stage.run(Recorder())
    folder = stage.out / "door"
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    if damaged == "meshes":
        shutil.rmtree(folder / damaged)
    elif damaged.startswith("half"):
        (folder / "joints.json").write_bytes(before[folder / "joints.json"][:300])
    else:
        (folder / damaged).unlink()
    outcome = stage.run(Recorder())
    assert outcome.data["left_out"] == []
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_what_a_user_adds_to_a_result_stays(stage: Predict) -> None:
    write_partnet(stage.source / "door")
    stage.run(Recorder())
    urdf = stage.out / "door" / "door.urdf"
    urdf.write_text(f"{urdf.read_text()}<!-- damping is to be measured -->", encoding="utf-8")
    stage.run(Recorder())
    assert urdf.read_text(encoding="utf-8").endswith("<!-- damping is to be measured -->")


def test_of_shapes_that_share_an_id_the_annotated_one_keeps_it(stage: Predict) -> None:
    write_partnet_mobility(stage.source / "dataset" / "7")
    write_partnet(stage.source / "data_v0" / "7")
    stage.run(Recorder())
    names = {path.name for path in stage.out.iterdir() if path.is_dir()}
    assert names == {"7", "data_v0__7"}
    assert predict._source(stage.out / "7") == str(stage.source / "dataset" / "7")
    write_partnet_mobility(stage.source / "again" / "7")
    found = replace(stage, out=stage.out.with_name("other")).run(Recorder())
    assert {Path(shape["folder"]).name for shape in found.data["shapes"]} == {"again__7", "data_v0__7", "dataset__7"}


def test_a_folder_of_scans_is_none_of_shapes(stage: Predict) -> None:
    stage.source.mkdir()
    for name in ("a.npz", "b.ply", "notes.txt"):
        (stage.source / name).touch()
    with pytest.raises(InputError, match="at least one shape at or below it, and not 2 scans, of which --category says"):
        stage.run(Recorder())
