"""Whole tables: rows that differ in the shapes with labels, in the sensor, or in the unlabelled shapes."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scanned_objects import cupboard_object
from scanned_workspace import CATEGORY, CPU, FAMILY, SCANS, Scanned, prepared_in, with_pseudo_labels
from trained_workspace import Recorder

from kinmo.config import ScansConfig, load_config
from kinmo.dataset.shape_dataset import fingerprint, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.category_rows import current_scores
from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
from kinmo.experiments.scan_tables.make_table import MakeTable
from kinmo.experiments.scan_tables.table_rows import SHARES, TABLES
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.experiments.variant_workspaces import Variant
from kinmo.io.readers import DSG_NET
from kinmo.learning.model_folder import WEIGHTS, networks_digest
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import count_objects, open_scans, write_scans
from kinmo.scans.rendering.labelled_frames import scan_object


def make(name: str, method: str, made: Scanned) -> MakeTable:
    """A table that is made."""
    stage = MakeTable(name, made.workspace, made.config, (method,), FAMILY, 1, **CPU)  # type: ignore[arg-type]
    stage.run(Recorder())
    return stage


def sure_of_hinges(made: Scanned, folder: Path) -> Scanned:
    """The same with a ranking that is trained until it knows pliers, and all of whose predictions are accepted."""
    one = made.changed(folder, "members = 3", "members = 1")
    every = one.changed(folder, "[scans]\n", "[refinement]\nchance = 0.0\ndoubt = 1.0\n[scans]\n")
    return every.changed(folder, "[ranking.training]\nepochs = 1\n", "[ranking.training]\nepochs = 40\n")


def training_shapes(workspace: Workspace) -> Sequence[IndexEntry]:
    return open_dataset(workspace, FAMILY).labelled[Split.TRAIN]


def test_all_networks_are_tested_on_the_scans_of_both_sensors(scanned: Scanned, tmp_path: Path) -> None:
    made = sure_of_hinges(scanned.copied(tmp_path), tmp_path)
    stage = make("sensors", "kinmo", made)
    assert stage.plan().steps == ()
    root, noisy = made.workspace, Variant(is_noisy=True).workspace(made.workspace)
    rows = TABLES["sensors"].rows
    weights = [row.run(CATEGORY, 0).weights(row.variant.workspace(root)) for row in rows]
    assert all(weights)
    assert weights[::2] == weights[1::2]
    assert len(set(weights)) == 4, "two settings with two sensors"
    inputs = [row.scores(root, CATEGORY, 0).current_inputs() for row in rows]
    assert all(inputs)
    assert len({str(own) for own in inputs}) == len(rows)
    assert not (noisy.path / "pseudo_labels").exists(), "both sensors have the same pseudo labels"
    pseudo = [
        {path.name for path in (place.scans / CATEGORY / "pseudo-kinmo").glob("*.safetensors")} for place in (root, noisy)
    ]
    assert pseudo[0] == pseudo[1] != set()
    assert "table-sensors" in EvaluateTrained(root, FAMILY, device="cpu").run(Recorder()).data
    ideal = open_scans(next(made.scans("test")))
    other = open_scans(noisy.scans / CATEGORY / "test" / ideal.path.name)
    np.testing.assert_array_equal(ideal.read("poses"), other.read("poses"))
    assert not np.array_equal(ideal.read("points"), other.read("points"))
    for path in made.scans("train"):  # as if other joints had been asked for
        provenance, target = open_scans(path).provenance, cupboard_object()
        write_scans(path, target, scan_object(target, ScansConfig(states=1, views=4, size=64, points=64), 0), provenance)
    assert set(current_scores(root, "sensors", CATEGORY, [0])[0].values()) == {None}


def test_networks_learn_from_pseudo_labels_and_oracle_labels_of_the_same_objects(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    made = sure_of_hinges(replace(scanned, workspace=Workspace(tmp_path / "workspace")), tmp_path)
    stage = MakeTable("2", made.workspace, made.config, ("kinmo",), FAMILY, 1, **CPU)  # type: ignore[arg-type]
    outcome = stage.run(Recorder())
    assert outcome.failed == 1, "self-training: after such a short training, networks are sure of no scan"
    assert stage.plan().steps == ()
    trained_on = {row[0]: row[1] for row in outcome.data[CATEGORY]["means"]["rows"]}
    labelled, unlabelled = len(training_shapes(made.workspace)), len(open_dataset(made.workspace).unlabelled)
    assert trained_on["supervised"] == str(labelled)
    assert trained_on["semi-weakly"] == trained_on["oracle labels"] == f"{labelled} + {unlabelled}"
    rows = {row.title: row for row in TABLES["2"].rows}
    trained = [rows[title].run(CATEGORY, 0).weights(made.workspace) for title in ("supervised", "semi-weakly", "oracle labels")]
    assert len({networks_digest(paths) for paths in trained if paths is not None}) == 3, "each has learned from other labels"
    whole, observer = TrainAll(made.workspace, made.config, FAMILY, **CPU), Recorder()  # type: ignore[arg-type]
    assert f"ancsh ({CATEGORY}, semi-weakly, seed 0)" in whole.run(observer).data
    assert f"ancsh ({CATEGORY}, semi-weakly, seed 0): already trained" in observer.notes, "on the same pseudo labels"
    assert whole.plan().steps == ()


def test_each_share_of_the_labels_has_motion_networks_of_its_own(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    make("3", "paper", made)
    counts = set()
    for share in SHARES:
        workspace = Variant(share).workspace(made.workspace)
        entries = open_dataset(workspace).labelled[Split.TRAIN]
        counts.add(len(entries))
        for model in ("gnn_fine", "axis"):
            inputs = workspace.inputs_of(f"train-{model}")
            assert inputs is not None
            assert inputs["data"]["training"] == fingerprint(entries)
            assert (workspace.models / model / WEIGHTS).is_file()
        assert workspace.inputs_of("pseudo-label-paper") is not None
        assert workspace.inputs_of("pseudo-label-kinmo") is None, "rows of this method were not asked for"
    assert len(counts) >= 3, "one to four shapes"


def test_networks_with_fewer_labels_are_tested_on_the_same_scans(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    part = Scanned(Variant(0.3).workspace(made.workspace), made.config)
    part.render(extra=("oracle",)).run(Recorder())
    whole, fewer = (open_scan_dataset(own.workspace, CATEGORY) for own in (made, part))
    assert fewer.structure == whole.structure
    assert [file.id for file in fewer.files["test"]] == [file.id for file in whole.files["test"]]
    train, oracle = ({file.id for file in whole.files[role]} for role in ("train", "oracle"))
    fewer_train, more_oracle = ({file.id for file in fewer.files[role]} for role in ("train", "oracle"))
    assert set() < fewer_train < train
    assert more_oracle == oracle | (train - fewer_train)
    row = next(row for row in TABLES["3"].rows if row.variant == Variant(0.3))
    tests = row.scores(made.workspace, CATEGORY, 0).files()
    assert [file.path for file in tests] == [file.path for file in whole.files["test"]]


def test_generated_shapes_are_trained_on_in_a_workspace_of_their_own(scanned: Scanned, tmp_path: Path) -> None:
    made, labels = with_pseudo_labels(scanned, tmp_path, DSG_NET)
    row = next(row for row in TABLES["4"].rows if row.title == "generated shapes")
    part = Scanned(row.variant.workspace(made.workspace), made.config)
    assert part.workspace.pseudo_labels == made.workspace.pseudo_labels
    part.render().run(Recorder())
    part.train("semi-weakly").run(Recorder())
    EvaluateScans(row.scores(made.workspace, CATEGORY, 0), "cpu").run(Recorder())
    found = WrittenTables(made.workspace, "4").write({CATEGORY: [0]})
    (shown,) = (line for line in found.data[CATEGORY]["means"]["rows"] if line[0] == "generated shapes")
    labelled = count_objects(open_scan_dataset(made.workspace, CATEGORY).files["train"])
    assert shown[1] == f"{labelled} + {len(labels)}"
    text = (found.path / CATEGORY / "means.md").read_text(encoding="utf-8")
    text = " ".join(text.split())
    assert "the authors' came from DSG-Net" in text
    assert f"Of {len(labels)} objects that pseudo labels give these joints, {len(labels)} truly have them" in text


def test_the_papers_settings_give_a_table(tmp_path: Path) -> None:
    made = prepared_in(tmp_path, count=4)
    sizes = SCANS.replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    renderer = 'renderer = "pybullet"\n' if find_spec("pybullet") else ""
    Path(made.config).write_text(f'extends = "paper"\n{sizes}{renderer}', encoding="utf-8")
    config = load_config(made.config)
    assert config.scans.release and config.ancsh.release
    made.render().run(Recorder())
    made.train().run(Recorder())
    EvaluateTrained(made.workspace, FAMILY, device="cpu").run(Recorder())
    (row, *_) = WrittenTables(made.workspace, "2").write({CATEGORY: [0]}, "ancsh").data[CATEGORY]["means"]["rows"]
    assert row[0] == "supervised"
    assert 0.0 < row[3] < 180.0, "degrees"
