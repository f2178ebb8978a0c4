"""`kinmo train all`, from motion networks to those that see scans."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned
from trained_workspace import Recorder, contents
from typer.testing import CliRunner

from kinmo.cli.app import app
from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.render_scans import USED
from kinmo.pipeline.train_all import TrainAll


def test_train_all_goes_the_whole_way_once(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, FAMILY, **CPU)
    steps = " ".join(stage.plan().steps)
    for step in ("gnn_fine", "gnn_coarse", "axis", "ranking", "label", "scan", "ancsh"):
        assert step in steps, "said before anything is done"
    dataset = open_dataset(stage.workspace, FAMILY)
    known = sum(map(len, dataset.labelled.values())) + len(dataset.hidden)
    assert f"scan {known + round(USED * len(dataset.unlabelled))} objects" in steps, "those to be labelled too"
    told = Recorder()
    found = stage.run(told)
    assert [note for note in told.notes if note.startswith("to do")]
    assert [note for note in told.notes if re.fullmatch("about .+ in all", note)]
    # such networks find nothing that moves, so that there are no pseudo labels to learn from
    assert [note for note in told.notes if note.startswith(f"{CATEGORY}: no scan is by a pseudo label")]
    assert {"gnn_fine", f"ancsh ({CATEGORY}, supervised, seed 0)"} <= found.data.keys()
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    surer = tmp_path / "surer.toml"
    words = Path(scanned.config).read_text(encoding="utf-8")
    surer.write_text(words.replace("[refinement]\n", "[refinement]\nchance = 0.9\n"), encoding="utf-8")
    assert any(step.startswith("label ") for step in replace(stage, config=str(surer)).plan().steps)
    before = contents(tmp_path / "workspace")
    stage.run(Recorder())
    assert contents(tmp_path / "workspace") == before
    other = TrainAll(Workspace(tmp_path / "workspace", method="paper"), scanned.config, FAMILY, **CPU)
    assert [step for step in other.plan().steps if "by paper" in step]
    trained = other.run(Recorder()).data
    assert other.plan().steps == ()
    of_its_own = {name for name in trained if "labels by paper" in name}
    assert trained.keys() - of_its_own <= found.data.keys(), "all that saw no pseudo label is shared"
    assert len(list((tmp_path / "workspace" / "by-paper").rglob("weights.json"))) == len(of_its_own)
    evaluation = ["eval", "--category", FAMILY, "--workspace", str(tmp_path / "workspace"), "--device", "cpu", "--workers", "1"]
    result = CliRunner().invoke(app, evaluation)
    assert result.exit_code == 0, result.output
    assert "Table 1" in result.output and "Table 2" in result.output, "those of shapes and those of scans"


def test_without_a_category_of_the_papers_train_all_says_that_scans_are_left_out(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, **CPU)
    assert "ancsh" not in " ".join(stage.plan().steps)
    with pytest.raises(InputError, match=r"expected a labelled shape of safe to train on; there are \w+"):
        TrainAll(Workspace(tmp_path / "workspace"), scanned.config, "safe", **CPU).plan()
