"""Tables whose rows differ in the shapes that have labels, or in the sensor, made whole."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scan_road import CATEGORY, FAMILY, HOW, Scanned
from scanned_objects import cupboard_object
from trained_workspace import Recorder

from kinmo.config import ScansConfig
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.experiments.scan_tables.table_rows import SHARES, TABLES
from kinmo.learning.model_folder import WEIGHTS, networks_digest
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import open_scans, write_scans
from kinmo.scans.rendering.labelled_frames import scan_object


def make(name: str, method: str, scanned: Scanned, folder: Path) -> MakeTable:
    """A table, made in a workspace of its own."""
    shutil.copytree(scanned.workspace.path, folder / "workspace")
    shutil.rmtree(folder / "workspace" / "eval", ignore_errors=True)  # of other tests
    stage = MakeTable(name, Workspace(folder / "workspace"), scanned.config, (method,), FAMILY, 1, **HOW)  # type: ignore[arg-type]
    stage.run(Recorder())
    return stage


def test_each_training_is_judged_on_the_scans_of_both_sensors(scanned: Scanned, tmp_path: Path) -> None:
    stage = make("sensors", "kinmo", replace(scanned, config=sure_of_hinges(scanned, tmp_path)), tmp_path)
    assert stage.plan().steps == ()
    root, rough = stage.workspace, Workspace(stage.workspace.root, is_rough=True)
    rows = TABLES["sensors"].rows
    weights = [row.cell(CATEGORY, 0).weights(row.workspace(root)) for row in rows]
    assert all(weights)
    assert weights[::2] == weights[1::2]
    assert len(set(weights)) == 4, "two settings by two sensors"
    found = [row.judged(root, CATEGORY, 0).held() for row in rows]
    assert all(found)
    assert len({str(made) for made in found}) == len(rows)
    assert not (rough.path / "pseudo").exists(), "both sensors see what has the same pseudo labels"
    pseudo = [{path.name for path in (place.own_scans / CATEGORY / "pseudo").iterdir()} for place in (root, rough)]
    assert pseudo[0] == pseudo[1] != set()
    assert "table-sensors" in JudgeTrained(root, FAMILY, device="cpu").run(Recorder()).data
    clean = open_scans(next((root.scans / CATEGORY / "test").glob("*.safetensors")))
    noisy = open_scans(rough.scans / CATEGORY / "test" / clean.path.name)
    np.testing.assert_array_equal(clean.read("poses"), noisy.read("poses"))
    assert not np.array_equal(clean.read("points"), noisy.read("points"))
    for path in (root.scans / CATEGORY / "train").glob("*.safetensors"):  # as if other joints had been asked for
        provenance, target = open_scans(path).provenance, cupboard_object()
        write_scans(path, target, scan_object(target, ScansConfig(states=1, views=4, size=64, points=64), 0), provenance)
    assert not any(row.judged(root, CATEGORY, 0).held() for row in TABLES["sensors"].rows)


def sure_of_hinges(scanned: Scanned, folder: Path) -> str:
    """The configuration with a ranking that is trained until it knows laptops, whose answers are all taken, in a file there."""
    text = Path(scanned.config).read_text(encoding="utf-8").replace("members = 3", "members = 1")
    text = text.replace("[refinement]\n", "[refinement]\nchance = 0.0\ndoubt = 1.0\n")
    path = folder / "sure.toml"
    path.write_text(text.replace("[ranking.training]\nepochs = 1\n", "[ranking.training]\nepochs = 40\n"), encoding="utf-8")
    return str(path)


def test_pseudo_labels_and_true_ones_of_the_same_objects_are_learnt_from(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    workspace, config = Workspace(tmp_path / "workspace"), sure_of_hinges(scanned, tmp_path)
    table = MakeTable("2", workspace, config, ("kinmo",), FAMILY, 1, **HOW)  # type: ignore[arg-type]
    outcome = table.run(Recorder())
    assert table.plan().steps == ()
    objects = {row[0]: row[1] for row in outcome.data[CATEGORY]["means"]["rows"]}
    labelled, unlabelled = (len(shapes) for shapes in (known(workspace), open_dataset(workspace).unlabelled))
    assert objects["supervised"] == str(labelled)
    assert objects["semi-weakly"] == objects["true labels"] == f"{labelled} + {unlabelled}"
    rows = {row.title: row for row in TABLES["2"].rows}
    trained = [rows[title].cell(CATEGORY, 0).weights(workspace) for title in ("supervised", "semi-weakly", "true labels")]
    digests = {networks_digest(paths) for paths in trained if paths is not None}
    assert len(digests) == 3, "each has learnt from something else"
    whole = TrainAll(workspace, config, FAMILY, **HOW)  # type: ignore[arg-type]
    told = Recorder()
    assert f"ancsh ({CATEGORY}, semi-weakly, seed 0)" in whole.run(told).data
    assert f"ancsh ({CATEGORY}, semi-weakly, seed 0): trained already" in told.notes, "by the same pseudo labels"
    assert whole.plan().steps == ()


def known(workspace: Workspace) -> Sequence[IndexEntry]:
    """The labelled objects to train on."""
    return open_dataset(workspace, FAMILY).labelled[Split.TRAIN]


def test_each_share_of_the_labels_has_motion_networks_of_its_own(scanned: Scanned, tmp_path: Path) -> None:
    stage = make("3", "paper", scanned, tmp_path)
    labelled = set()
    for share in SHARES:
        workspace, labels = (Workspace(stage.workspace.root, share, method=method) for method in ("kinmo", "paper"))
        entries = open_dataset(workspace).labelled[Split.TRAIN]
        labelled.add(len(entries))
        for model in ("gnn_fine", "axis"):
            record = workspace.record(f"train-{model}")
            assert record is not None
            assert record.inputs["data"]["training"] == open_dataset(workspace).fingerprint(entries)
            assert (workspace.models / model / WEIGHTS).is_file()
        assert not (labels.models / "axis").exists(), "methods share motion networks"
        assert labels.record("pseudo-label") is not None
        assert workspace.record("pseudo-label") is None, "of the other method, which was not asked for"
    assert len(labelled) >= 3, "one to four shapes"
