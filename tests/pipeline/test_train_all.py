"""`kinmo train all`: from motion networks to networks for scans."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, FAMILY, Scanned
from trained_workspace import Recorder, contents
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.pseudo_label_shapes import PseudoLabel
from kinmo.pipeline.scans.render_scans import USED_SHARE, RenderScans
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.train_all import NO_CATEGORY, NO_LABELS, TrainAll
from kinmo.pipeline.train_motion import TrainMotion


def new_workspace(scanned: Scanned, folder: Path) -> Workspace:
    """A workspace with the same prepared shapes and nothing else."""
    shutil.copytree(scanned.workspace.prepared, folder / "workspace" / "prepared")
    return Workspace(folder / "workspace")


def test_everything_is_trained_once(scanned: Scanned, tmp_path: Path) -> None:
    stage = TrainAll(new_workspace(scanned, tmp_path), scanned.config, FAMILY, device="cpu")
    steps = " ".join(stage.plan().steps)
    for step in ("gnn_fine", "gnn_coarse", "axis", "ranking", "label", "scan", "ancsh"):
        assert step in steps, "the plan lists it before anything is done"
    dataset = open_dataset(stage.workspace, FAMILY)
    labelled = sum(map(len, dataset.labelled.values())) + len(dataset.oracle)
    count = labelled + round(USED_SHARE * len(dataset.unlabelled))
    assert f"scan {count} objects" in steps, "shapes that will have pseudo labels are counted"
    recorder = Recorder()
    found = stage.run(recorder)
    assert [note for note in recorder.notes if note.startswith("to do")]
    assert [note for note in recorder.notes if re.fullmatch("about .+ in all", note)]
    # networks of one epoch find nothing that moves: there are no pseudo labels
    assert f"{CATEGORY}: {NO_LABELS}" in recorder.notes
    assert {"gnn_fine", f"ancsh ({CATEGORY}, supervised, seed 0)"} <= found.data.keys()
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    before = contents(stage.workspace.path)
    stage.run(Recorder())
    assert contents(stage.workspace.path) == before

    stricter = tmp_path / "stricter.toml"
    text = Path(scanned.config).read_text(encoding="utf-8")
    stricter.write_text(f"{text}\n[refinement]\nchance = 0.9\n", encoding="utf-8")
    assert any(step.startswith("label ") for step in replace(stage, config=str(stricter)).plan().steps)

    other = replace(stage, method="paper")
    assert [step for step in other.plan().steps if "by paper" in step]
    trained = other.run(Recorder()).data
    assert other.plan().steps == ()
    own = {name for name in trained if "labels by paper" in name}
    assert trained.keys() - own <= found.data.keys(), "networks that saw no pseudo label are shared"
    assert len(list((stage.workspace.models / "ancsh").glob("*/*paper*/**/weights.json"))) == len(own)
    assert (stage.workspace.pseudo_labels / "paper").is_dir()

    evaluation = ["eval", "--category", FAMILY, "--workspace", str(stage.workspace.path), "--device", "cpu", "--workers", "1"]
    result = CliRunner().invoke(app, evaluation)
    assert result.exit_code == 0, result.output
    assert "Table 1" in result.output and "Table 2" in result.output, "tables of shapes and of scans"


def test_without_one_of_the_papers_categories_scans_are_skipped_with_a_note(scanned: Scanned, tmp_path: Path) -> None:
    stage = TrainAll(new_workspace(scanned, tmp_path), scanned.config, device="cpu")
    assert "ancsh" not in " ".join(stage.plan().steps)
    recorder = Recorder()
    stage.run(recorder)
    assert NO_CATEGORY in recorder.notes


def test_a_category_that_cannot_be_trained_stops_no_other(scanned: Scanned, monkeypatch: pytest.MonkeyPatch) -> None:
    trained = []

    def train(stage: TrainScans, observer: Observer) -> Outcome:
        if stage.category == "Refrigerator":
            raise InputError(stage.workspace.scans, "expected scans of a labelled shape to train on")
        trained.append(stage.category)
        return Outcome(None, {}, "")

    for kind in (TrainMotion, PseudoLabel, RenderScans):
        monkeypatch.setattr(kind, "run", lambda stage, observer: Outcome(None, {}, ""))
    monkeypatch.setattr(TrainScans, "run", train)
    monkeypatch.setattr(TrainAll, "plan", lambda stage: Plan((), 0.0))
    monkeypatch.setattr(TrainAll, "_categories", lambda stage, dataset: ["Refrigerator", CATEGORY])
    recorder = Recorder()
    outcome = TrainAll(scanned.workspace, scanned.config, device="cpu").run(recorder)
    assert trained == [CATEGORY] and outcome.failed == 1
    assert f"Refrigerator: skipped: {scanned.workspace.scans}: expected scans of a labelled shape to train on" in recorder.notes


def test_an_unknown_category_is_refused(scanned: Scanned) -> None:
    with pytest.raises(InputError, match=r"expected a labelled shape of safe to train on; there are \w+"):
        TrainAll(scanned.workspace, scanned.config, "safe", device="cpu").plan()
