"""Prediction into folders that have results: they are kept, completed or replaced, and nothing of a user is lost."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from datasets import write_partnet
from rigid_method import source_of
from trained_workspace import METHODS, Recorder, Trained, contents

from kinmo.io.readers.stated_facts import StatedFacts
from kinmo.pipeline.predict_shapes import PredictShapes


def test_the_prediction_for_another_shape_is_not_replaced(stage: PredictShapes) -> None:
    for place in ("a", "b"):
        write_partnet(stage.sources[0] / place / "cabinet")
    assert replace(stage, sources=[stage.sources[0] / "a"]).run(Recorder()).failed == 0
    outcome = replace(stage, sources=[stage.sources[0] / "b"]).run(Recorder())
    (line,) = outcome.data["skipped"]
    assert line == (
        f"{stage.out / 'cabinet'}: exists, with the prediction for {stage.sources[0] / 'a' / 'cabinet'}: "
        "name another folder by --out"
    )
    assert source_of(stage.out / "cabinet") == str(stage.sources[0] / "a" / "cabinet")


def test_the_same_shape_by_another_path_is_up_to_date(stage: PredictShapes, monkeypatch: pytest.MonkeyPatch) -> None:
    write_partnet(stage.sources[0] / "door")
    (stage.sources[0] / "deep").mkdir()
    stage.run(Recorder())
    monkeypatch.chdir(stage.sources[0] / "deep")
    assert replace(stage, sources=[Path("../door")]).plan().steps == ()


def test_a_result_that_a_killed_run_was_replacing_keeps_its_files(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    stage.run(Recorder())
    (stage.out / "door" / "notes.txt").write_text("mine")
    (stage.out / "door").rename(stage.out / ".door.old~")
    assert stage.run(Recorder()).failed == 0
    assert (stage.out / "door" / "notes.txt").read_text() == "mine"
    assert not list(stage.out.glob(".door*~"))


@pytest.mark.parametrize("damaged", ["door.urdf", "joints.json", "meshes", "half of joints.json"])
def test_an_incomplete_result_is_made_again(stage: PredictShapes, damaged: str) -> None:
    write_partnet(stage.sources[0] / "door")
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
    assert outcome.data["skipped"] == []
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_edits_of_a_user_stay(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    stage.run(Recorder())
    urdf = stage.out / "door" / "door.urdf"
    urdf.write_text(f"{urdf.read_text()}<!-- damping is to be measured -->", encoding="utf-8")
    stage.run(Recorder())
    assert urdf.read_text(encoding="utf-8").endswith("<!-- damping is to be measured -->")


def test_edits_of_a_user_are_not_replaced_if_the_settings_change(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    stage.run(Recorder())
    urdf = stage.out / "door" / "door.urdf"
    before = urdf.read_text(encoding="utf-8")
    urdf.write_text(f"{before}<!-- edited -->", encoding="utf-8")
    assert stage.plan().steps == ()
    other = replace(stage, facts=StatedFacts(metres_per_unit=2.0))
    remedy = "was edited after kinmo wrote it: move it away, or name another folder by --out"
    assert other.run(Recorder()).data["skipped"] == [f"{urdf}: {remedy}"]
    assert urdf.read_text(encoding="utf-8") == f"{before}<!-- edited -->"
    urdf.rename(urdf.with_name("mine.urdf"))
    assert other.run(Recorder()).failed == 0
    assert urdf.read_text(encoding="utf-8") != before


def test_removed_files_of_other_formats_are_named(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    replace(stage, formats=("urdf", "mjcf", "glb")).run(Recorder())
    fewer, again = Recorder(), Recorder()
    replace(stage, formats=("urdf",)).run(fewer)
    line = "removed of the earlier prediction: door.glb, door.xml (add --format urdf,mjcf,glb to write them again)"
    assert [note for note in fewer.notes if note.startswith("removed")] == [line]
    assert not (stage.out / "door" / "door.xml").exists()
    replace(stage, formats=("urdf", "mjcf", "glb")).run(again)
    assert not any(note.startswith("removed") for note in again.notes)
    assert (stage.out / "door" / "door.xml").is_file()


@pytest.mark.parametrize("damaged", [False, True])
def test_files_of_a_user_stay_if_a_shape_is_predicted_again(stage: PredictShapes, damaged: bool) -> None:
    write_partnet(stage.sources[0] / "door")
    stage.run(Recorder())
    folder = stage.out / "door"
    mine = [folder / "notes.txt", folder / "photos" / "front.txt", folder / "meshes" / "mine.obj"]
    for path in mine:
        path.parent.mkdir(exist_ok=True)
        path.write_text(path.name, encoding="utf-8")
    if damaged:
        (folder / "joints.json").write_text("{", encoding="utf-8")
    assert replace(stage, facts=StatedFacts(metres_per_unit=2.0)).run(Recorder()).failed == 0
    assert [path.read_text(encoding="utf-8") for path in mine] == [path.name for path in mine]


def test_a_result_without_its_cache_is_recognised_and_replaced(stage: PredictShapes) -> None:
    write_partnet(stage.sources[0] / "door")
    stage.run(Recorder())
    (stage.out / ".kinmo.jsonl").unlink()
    assert stage.plan().steps
    assert stage.run(Recorder()).failed == 0
    assert stage.plan().steps == ()


def test_predict_replaces_no_folder_that_it_did_not_write(trained: Trained, tmp_path: Path) -> None:
    shape = next((trained.shapes / "partnet").iterdir())
    shutil.copytree(shape, tmp_path / shape.name)
    before = contents(tmp_path)
    outcome = PredictShapes([tmp_path / shape.name], tmp_path, trained.workspace, METHODS[0], device="cpu").run(Recorder())
    assert outcome.failed == 1 and "kinmo predict did not write it" in outcome.data["skipped"][0]
    assert contents(tmp_path) == before
