"""The stage `export`: several results, targets that must not be replaced, and plans."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from cabinet_results import predict_cabinets, result_in
from predicted_cabinet import CORRECTIONS, write_cabinet_glb
from trained_workspace import Recorder, contents

import kinmo
from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers.stated_facts import StatedFacts
from kinmo.pipeline.export_results import ExportResults, find_results
from kinmo.pipeline.prepare_shapes import Prepare


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """Results for three cabinets, the first of which has corrections that are not applied yet."""
    for name in ("a", "b", "sub/a"):
        write_cabinet_glb(tmp_path / "shapes" / f"{name}.glb")
    assert predict_cabinets(tmp_path / "shapes", tmp_path / "out", StatedFacts("StorageFurniture")).failed == 0
    (tmp_path / "out" / "a" / "overrides.toml").write_text(CORRECTIONS, encoding="utf-8")
    return tmp_path / "out"


def joints_json(folder: Path) -> dict:
    return dict(json.loads((folder / "joints.json").read_text(encoding="utf-8")))


def test_every_result_has_its_own_corrections(results: Path) -> None:
    recorder = Recorder()
    outcome = ExportResults(results).run(recorder)
    assert outcome.failed == 0 and outcome.path == results
    assert [result["corrected"] for result in outcome.data["results"]] == [True, False, False]
    lines = outcome.text.splitlines()
    assert [line for line in lines if not line.startswith(" ")] == [
        "a (category StorageFurniture)",
        "b (category StorageFurniture)",
        "sub__a (category StorageFurniture)",
        "3 results, 8 joints, 1 corrected, 0 skipped",
    ]
    assert "a: knob has no part left: dropped" in recorder.notes
    once = contents(results)
    ExportResults(results, workers=2).run(Recorder())
    assert contents(results) == once


def test_one_mistake_stops_no_other_result(results: Path) -> None:
    (results / "b" / "overrides.toml").write_text("[bodies.dor]\nflip = true", encoding="utf-8")
    before = contents(results / "b")
    recorder = Recorder()
    outcome = ExportResults(results).run(recorder)
    (problem,) = outcome.data["skipped"]
    assert problem.startswith(f"{results / 'b' / 'overrides.toml'}: bodies.dor: ") and outcome.failed == 1
    assert f"skipped: {problem}" in recorder.notes
    assert contents(results / "b") == before and "correction" in joints_json(results / "a")


def test_corrected_results_become_training_data(results: Path, tmp_path: Path) -> None:
    (results / "sub__a" / "overrides.toml").touch()
    outcome = ExportResults(results, ("partnet_mobility",), tmp_path / "annotated").run(Recorder())
    assert outcome.failed == 0
    prepared = Prepare(tmp_path / "annotated", Workspace(tmp_path / "workspace")).run(Recorder())
    assert len(prepared.data["included"]) == 2
    (skipped,) = prepared.data["skipped"]
    assert "b" in str(skipped) and "predicted, not annotated" in str(skipped)


def test_an_object_of_unknown_category_can_be_prepared(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    recorder = Recorder()
    ExportResults(folder, ("partnet_mobility",), tmp_path / "annotated").run(recorder)
    assert any(
        "the category is unknown: to state it, run kinmo predict again with --category" in note for note in recorder.notes
    )
    prepared = Prepare(tmp_path / "annotated", Workspace(tmp_path / "workspace")).run(Recorder())
    assert prepared.data["skipped"] == [] and len(prepared.data["repaired"]) == 1


def test_a_plan_writes_nothing_and_names_what_is_impossible(results: Path, tmp_path: Path) -> None:
    (results / "b" / "overrides.toml").write_text("[bodies.dor]\nflip = true", encoding="utf-8")
    before = contents(tmp_path)
    plan = ExportResults(results, ("urdf",), tmp_path / "robots").plan()
    assert plan.steps == (
        f"write {tmp_path / 'robots' / 'a'}: urdf, corrected by overrides.toml",
        f"write {tmp_path / 'robots' / 'sub__a'}: urdf",
    )
    (problem,) = plan.impossible
    assert problem.startswith(f"{results / 'b' / 'overrides.toml'}: bodies.dor: ")
    assert contents(tmp_path) == before and not (tmp_path / "robots").exists()


def test_only_exports_of_the_same_result_are_replaced(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    stage = ExportResults(folder, ("urdf",), tmp_path / "robots")
    target = tmp_path / "robots" / "cabinet"
    target.mkdir(parents=True)
    (target / "notes.txt").write_text("mine", encoding="utf-8")
    outcome = stage.run(Recorder())
    assert outcome.path is None and outcome.data["skipped"] == [
        f"{target}: exists, and is no export of the same result: name another folder by --out"
    ]
    assert [path.name for path in target.iterdir()] == ["notes.txt"]
    (target / "notes.txt").unlink()
    assert stage.run(Recorder()).failed == 0
    (target / "notes.txt").write_text("mine", encoding="utf-8")
    assert replace(stage, formats=("joints_json",)).run(Recorder()).failed == 0
    assert {path.name for path in target.iterdir()} == {"joints.json", "overrides.toml", "notes.txt"}


def test_a_copy_is_corrected_on_its_own(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    stage = ExportResults(folder, out=tmp_path / "copies")
    assert stage.run(Recorder()).failed == 0
    copy = tmp_path / "copies" / "cabinet"
    once = contents(copy)
    assert ExportResults(copy).run(Recorder()).failed == 0 and contents(copy) == once
    mine = "[bodies.knob]\nname = 'pull'"
    (copy / "overrides.toml").write_text(mine, encoding="utf-8")
    for _ in range(2):
        assert ExportResults(copy).run(Recorder()).data["results"][0]["joints"] == 3
        (problem,) = stage.run(Recorder()).data["skipped"]
        assert problem.startswith(f"{copy / 'overrides.toml'}: was edited after kinmo wrote it: move it away")
        assert (copy / "overrides.toml").read_text(encoding="utf-8") == mine
    (copy / "overrides.toml").unlink()
    assert stage.run(Recorder()).failed == 0 and contents(copy) == once


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("cabinet.urdf", "move it away, then run kinmo export again"),
        ("joints.json", "move it away, then run kinmo predict again"),
    ],
)
def test_edited_files_are_not_replaced_and_the_remedy_works(tmp_path: Path, name: str, remedy: str) -> None:
    folder = result_in(tmp_path)
    file = folder / name
    text = file.read_text(encoding="utf-8")
    file.write_text(f"{text}\n", encoding="utf-8")
    (problem,) = ExportResults(folder).run(Recorder()).data["skipped"]
    assert problem == f"{file}: was edited after kinmo wrote it: {remedy}; corrections belong into overrides.toml"
    assert ExportResults(folder).plan().impossible == (problem,)
    assert file.read_text(encoding="utf-8") == f"{text}\n"
    file.rename(tmp_path / name)
    predict_cabinets(tmp_path / "cabinet.glb", tmp_path / "out")
    assert ExportResults(folder).run(Recorder()).failed == 0
    assert "correction" in joints_json(folder)


def test_exports_below_the_results_are_no_results(results: Path) -> None:
    stage = ExportResults(results, out=results / "copies")
    names = [result["folder"] for result in stage.run(Recorder()).data["results"]]
    assert [result["folder"] for result in stage.run(Recorder()).data["results"]] == names
    assert sorted(path.name for path in (results / "copies").iterdir() if path.is_dir()) == ["a", "b", "sub__a"]


def test_the_folder_of_a_ros_package_has_its_name(results: Path, tmp_path: Path) -> None:
    stage = ExportResults(results / "b", ("urdf", "joints_json"), tmp_path / "ros", package="b_description")
    for _ in range(2):
        recorder = Recorder()
        folder = stage.run(recorder).path
        assert folder == tmp_path / "ros" / "b_description"
        line = f"written into {folder}: ROS looks for package://b_description/ in a folder of that name"
        assert line in recorder.notes
    file = folder / "b_description.urdf"
    assert "package://b_description/meshes/" in file.read_text(encoding="utf-8")
    assert not any("skipped" in line for line in kinmo.load(file).repairs)
    once = contents(folder)
    assert ExportResults(folder, package="b_description").run(Recorder()).failed == 0 and contents(folder) == once


def test_predict_regards_exported_results_as_up_to_date(results: Path, tmp_path: Path) -> None:
    ExportResults(results).run(Recorder())
    once = contents(results)
    assert predict_cabinets(tmp_path / "shapes", results, StatedFacts("StorageFurniture")).failed == 0
    assert contents(results) == once


def test_the_files_of_a_result_stand_for_its_folder(tmp_path: Path) -> None:
    folder = result_in(tmp_path)
    for name in ("joints.json", "overrides.toml"):
        assert ExportResults(folder / name).run(Recorder()).path == folder


def test_two_results_never_have_one_target(tmp_path: Path) -> None:
    for place in ("a/b", "a__b"):
        shutil.copytree(result_in(tmp_path), tmp_path / "results" / place)
    with pytest.raises(InputError, match=r"--out: .*a/b and .*a__b would both be .*a__b: export one of them by itself"):
        ExportResults(tmp_path / "results", out=tmp_path / "exported").run(Recorder())
    assert not list((tmp_path / "exported").glob("[!.]*"))


def test_results_are_found_in_the_order_of_their_names(results: Path) -> None:
    (results / ".hidden").mkdir()
    (results / ".hidden" / "joints.json").touch()
    (results / "c").symlink_to(results / "a")
    assert [folder.name for folder in find_results(results)] == ["a", "b", "sub__a"]


def test_what_cannot_be_exported_is_one_line(results: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for stage, message in (
        (ExportResults(tmp_path / "nowhere"), "nowhere: no such folder"),
        (ExportResults(tmp_path / "shapes" / "a.glb"), r"a\.glb: expected a folder of kinmo predict"),
        (ExportResults(tmp_path / "empty"), r"empty: expected a result of kinmo predict, with joints\.json, at or below it"),
        (ExportResults(results, ("lego",)), "formats: unknown format lego; expected one of"),
        (ExportResults(results, source=tmp_path / "a.glb"), "--source: applies only to one result; found 3 below"),
        (ExportResults(results, out=tmp_path / "ros", package="p"), "--package: applies only to one result; found 3"),
        (ExportResults(results, package="p"), "--package: applies only to one result; found 3"),
        (
            ExportResults(results / "a", package="p"),
            "--package: ROS looks for it in a folder of that name, not in a: add -o FOLDER to write FOLDER/p",
        ),
        (ExportResults(results / "a", out=results), "--out: .*a would be replaced: leave --out away"),
        (ExportResults(results / "a", out=results / "a"), "--out: lies in the result .*a: name a folder elsewhere"),
        (ExportResults(results, out=results / "a" / "copies"), "--out: lies in the result .*a: name a folder elsewhere"),
    ):
        before = contents(tmp_path)
        for call in (stage.plan, lambda stage=stage: stage.run(Recorder())):
            with pytest.raises(InputError, match=message) as caught:
                call()
            assert "\n" not in str(caught.value)
        assert contents(tmp_path) == before
