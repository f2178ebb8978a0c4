"""Networks that see scans, trained on true labels, pseudo labels and their own."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, FAMILY, CPU, SCANS, Scanned, prepared_in, pseudo_labelled
from trained_workspace import Recorder, contents

from kinmo.config import load_config
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.experiments.self_training.self_training_stage import SelfLabel
from kinmo.pipeline import each_shape
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.example_scan import ExampleScan
from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import Cell, scores_path, trained_cells
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import ROLES, count_objects, open_scans
from kinmo.view.scan_sections import picture_sections


def test_the_papers_ways_go_the_whole_road(tmp_path: Path) -> None:
    made = prepared_in(tmp_path, count=4)
    sizes = SCANS.replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    Path(made.config).write_text(f'extends = "paper"\n{sizes}', encoding="utf-8")
    config = load_config(made.config)
    assert (config.scans.renderer, config.scans.canonical, config.scans.sampling) == ("pybullet", "file", "release")
    assert (config.ancsh.axes, config.ancsh.normalised, config.ancsh.ties) == ("camera", "object", "pairs")
    assert not (config.ancsh.maps or config.ancsh.global_head)
    made.render().run(Recorder())
    made.train("supervised").run(Recorder())
    JudgeTrained(made.workspace, FAMILY, device="cpu").run(Recorder())
    (row, *_) = WrittenTables(made.workspace, "2").write({CATEGORY: [0]}, "ancsh").data[CATEGORY]["means"]["rows"]
    assert row[0] == "supervised"
    assert 0.0 < row[3] < 180.0, "degrees"


def test_networks_are_trained_once_and_judged_frame_by_frame(scanned: Scanned) -> None:
    told = Recorder()
    scanned.train("supervised").run(told)
    assert all("trained already" in note for note in told.notes)
    assert scanned.train("supervised").plan().steps == ()
    cell = Cell(CATEGORY, "supervised", 0)
    assert trained_cells(scanned.workspace) == [cell]
    stage = EvaluateScans(scanned.workspace, cell, "cpu")
    stage.run(Recorder())
    assert stage.plan().steps == ()
    dataset = open_scan_dataset(scanned.workspace, CATEGORY)
    lines = scores_path(scanned.workspace, cell, on_rough=False).read_text().splitlines()
    assert len(lines) == sum(file.frames for file in dataset.files["test"])


def test_networks_that_label_scans_are_trained_first_and_their_labels_are_used(
    scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    config = tmp_path / "longer.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    config.write_text(text.replace("learning_rate = 1e-3", "learning_rate = 1e-2"), encoding="utf-8")
    stage = TrainAncsh(workspace, str(config), FAMILY, "semi", **CPU)
    planned = stage.plan()
    assert [step.split(" (")[0] for step in planned.steps if step.startswith("train")] == ["train ancsh", "train npcs"] * 2
    assert [step for step in planned.steps if step.startswith("label")]
    assert replace(stage, category=CATEGORY).plan() == planned, "however it is spelled"
    told = Recorder()
    stage.run(told)
    assert stage.plan().steps == ()
    header = json.loads((Cell(CATEGORY, "semi", 0).folder(workspace, "ancsh") / "weights.json").read_text())
    dataset = open_scan_dataset(workspace, CATEGORY)
    labelled = sorted((workspace.own_scans / CATEGORY / "semi-0").glob("*.safetensors"))
    assert labelled
    assert header["facts"]["objects"] == count_objects(dataset.files["train"]) + len(labelled)
    assert {open_scans(path).structure for path in labelled} <= {dataset.structure}
    before = contents(workspace.path)
    stage.run(Recorder())
    assert contents(workspace.path) == before
    own, gone = SelfLabel(workspace, CATEGORY, confidence=0.0, **CPU), labelled[0].read_bytes()
    assert own.plan().steps == ()
    workspace.forget(f"self-label-{CATEGORY}-0")  # as if it had been killed before the first one was done
    labelled[0].unlink()
    kept = {path: path.stat().st_mtime_ns for path in labelled[1:]}
    assert len(own.plan().steps) == 1
    own.run(Recorder())
    assert {path: path.stat().st_mtime_ns for path in labelled[1:]} == kept, "what was labelled stays as it is"
    assert labelled[0].read_bytes() == gone
    monkeypatch.setattr(each_shape, "JOBS_A_PROCESS", 1)
    by_one = contents(labelled[0].parent)
    workspace.forget(f"self-label-{CATEGORY}-0")
    for path in labelled:
        path.unlink()
    replace(own, workers=2).run(Recorder())
    assert contents(labelled[0].parent) == by_one, "by two processes too"


def test_networks_learn_from_pseudo_labels_too(scanned: Scanned, tmp_path: Path) -> None:
    workspace, _ = pseudo_labelled(scanned, tmp_path / "workspace")
    Render(workspace, scanned.config, FAMILY).run(Recorder())
    stage = TrainAncsh(workspace, scanned.config, FAMILY, "semi-weakly", **CPU)
    stage.run(Recorder())
    assert stage.plan().steps == ()
    dataset = open_scan_dataset(workspace, CATEGORY)
    config = load_config(scanned.config)
    others = TrainAncsh(workspace, scanned.config, FAMILY, "supervised", **CPU)
    budgets = [[(each.work.schedule, each.work.units) for each in one._fittings(config)] for one in (stage, others)]
    assert budgets[0] == budgets[1], "as many steps on as many frames, whatever there is to learn from"
    facts = json.loads((Cell(CATEGORY, "semi-weakly", 0).folder(workspace, "npcs") / "weights.json").read_text())["facts"]
    assert facts["labelled"] == count_objects(dataset.files["train"])
    assert facts["objects"] == facts["labelled"] + count_objects(dataset.files["pseudo"])
    assert count_objects(dataset.files["pseudo"]) > 0


def test_networks_learn_from_pseudo_labels_of_generated_shapes_where_there_are_no_others(
    scanned: Scanned, tmp_path: Path
) -> None:
    workspace, labels = pseudo_labelled(scanned, tmp_path / "workspace", layout="dsg_net")
    Render(workspace, scanned.config, FAMILY).run(Recorder())
    later = TrainAll(workspace, scanned.config, FAMILY, **CPU)._later(open_dataset(workspace))
    (training,) = (stage for stage in later if isinstance(stage, TrainAncsh))
    assert training.setting == "dsg-net"
    training.run(Recorder())
    EvaluateScans(workspace, Cell(CATEGORY, "dsg-net", 0), "cpu").run(Recorder())
    found = WrittenTables(workspace, "4").write({CATEGORY: [0]})
    (row,) = (row for row in found.data[CATEGORY]["means"]["rows"] if row[0] == "generated shapes")
    labelled = count_objects(open_scan_dataset(workspace, CATEGORY).files["train"])
    assert row[1] == f"{labelled} + {len(labels)}"
    assert "not DSG-Net's own" in " ".join(found.text.split())


def test_each_method_has_pseudo_labels_scans_and_networks_of_its_own(scanned: Scanned, tmp_path: Path) -> None:
    workspace, (label, *_) = pseudo_labelled(scanned, tmp_path / "workspace")
    other = Workspace(workspace.root, method="paper")
    shutil.copytree(label.parent, other.pseudo / label.parent.name)
    for place in (workspace, other):
        Render(place, scanned.config, FAMILY).run(Recorder())
        TrainAncsh(place, scanned.config, FAMILY, "semi-weakly", **CPU).run(Recorder())
    known, others = (open_scan_dataset(place, CATEGORY).files for place in (workspace, other))
    assert count_objects(known["pseudo"]) > count_objects(others["pseudo"]) == 1
    for role in set(ROLES) - {"pseudo"}:
        assert [file.path for file in known[role]] == [file.path for file in others[role]], role
    table = JudgeTrained(workspace, FAMILY, device="cpu").run(Recorder()).data["table-2"][CATEGORY]["means"]
    trained = {row[0]: row[1] for row in table["rows"] if row[2] == "0"}
    assert trained["semi-weakly"] != trained["semi-weakly, paper"] == f"{trained['supervised']} + 1"
    assert {"semi-weakly, paper against supervised", "semi-weakly against semi-weakly, paper"} <= {
        row[0] for row in table["rows"]
    }
    shown = [picture.title for section in picture_sections(workspace) for picture in section.pictures]
    assert {title.split(":")[0] for title in shown} >= {"supervised", "semi-weakly", "semi-weakly, paper"}
    example = ExampleScan(workspace, FAMILY, tmp_path / "scan.npz", Render(workspace, scanned.config, FAMILY))
    example.run(Recorder())

    def trained_for(method: str | None) -> str:
        stage = PredictScans(example.path, tmp_path / "out", workspace, FAMILY, method=method, **CPU)
        return str(stage.run(Recorder()).data["trained"])

    assert trained_for(None) == trained_for("kinmo") == f"{CATEGORY}, semi-weakly, seed 0"
    assert trained_for("paper") == f"{CATEGORY}, semi-weakly, seed 0, labels by paper"
    shutil.rmtree(workspace.models / "ancsh")
    assert trained_for(None) == trained_for("paper"), "which is all that there is"
