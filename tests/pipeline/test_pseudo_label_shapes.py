"""Pseudo labels: which shapes get one, in which layout, and when they are made again."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from trained_workspace import METHODS, Recorder, Trained, contents

from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import read_partnet_mobility
from kinmo.learning.model_folder import CONFIG, ModelFolder
from kinmo.methods import load_method
from kinmo.pipeline.pseudo_label_files import LABEL, REPORT, label_name, labels_folder
from kinmo.pipeline.pseudo_label_shapes import PseudoLabel


def labels_of(workspace: Workspace) -> Path:
    return labels_folder(workspace, "kinmo")


def test_accepted_labels_are_partnet_mobility_shapes(trained: Trained) -> None:
    report = trained.outcomes["pseudo-label"].data
    folders = [path.parent for path in labels_of(trained.workspace).glob(f"*/{LABEL}")]
    accepted = int(next(row for row in report["tables"][0]["rows"] if row[0] == "all")[2])
    assert len(folders) == accepted > 0
    for folder in folders:
        shape = read_partnet_mobility(folder)
        assert shape.mobility is not None and list(shape.mobility.movable())


def test_the_labels_of_each_method_have_their_own_folder(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    before = contents(labels_of(workspace))
    outcome = PseudoLabel(workspace, "pliers", "paper", 0.0, device="cpu").run(Recorder())
    assert outcome.path == workspace.pseudo_labels / "paper"
    assert (outcome.path / REPORT).is_file() and "by paper" in outcome.text
    assert contents(labels_of(workspace)) == before
    assert PseudoLabel(workspace, threshold=0.0, device="cpu").plan().steps == ()


def test_labelled_shapes_get_no_pseudo_labels(trained: Trained) -> None:
    decided = set(Cache(labels_of(trained.workspace)))
    labelled = {found.id for found in discover(trained.shapes / "partnet_mobility")}
    assert decided and not decided & labelled


def test_an_unreadable_shape_keeps_its_label_and_is_labelled_once_it_is_readable(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    folder = labels_of(workspace)
    entry = next(each for each in open_dataset(workspace).unlabelled if (folder / label_name(each)).is_dir())
    name, label = label_name(entry), folder / label_name(entry) / LABEL
    before = contents(folder)
    Cache(folder).forget(name)
    source, away, recorder = Path(entry.source), tmp_path / "away", Recorder()
    stage = replace(trained.stages["pseudo-label"], workspace=workspace)  # type: ignore[type-var]
    source.rename(away)
    try:
        outcome = stage.run(recorder)
    finally:
        away.rename(source)
    assert outcome.failed == len(outcome.data["failed"]) == 1
    assert [note for note in recorder.notes if note.startswith(f"failed: {source}: ")]
    assert label.exists() and name not in Cache(folder)
    assert stage.plan().steps
    assert stage.run(Recorder()).failed == 0
    assert contents(folder) == before


def test_a_higher_threshold_accepts_fewer_shapes(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)

    def accepted() -> set[str]:
        return {path.parent.name for path in labels_of(workspace).glob(f"pliers*/{LABEL}")}

    before = accepted()
    PseudoLabel(workspace, "pliers", threshold=0.5, device="cpu").run(Recorder())
    assert accepted() < before
    PseudoLabel(workspace, "pliers", threshold=1.0, device="cpu").run(Recorder())
    assert not accepted()


def test_a_run_for_one_category_keeps_the_labels_and_counts_of_others(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    stale = labels_of(workspace) / "no such shape"
    stale.mkdir()
    whole = PseudoLabel(workspace, threshold=0.0, device="cpu")
    outcome = PseudoLabel(workspace, "pliers", threshold=1.0, device="cpu").run(Recorder())
    categories = {row[0]: row for row in outcome.data["tables"][0]["rows"]}
    assert set(categories) > {"Pliers", "all"}
    assert int(categories["Pliers"][2]) == 0
    assert len(outcome.data["ways"]) == 2
    assert not stale.exists()
    assert replace(whole, category="stapler").plan().steps == ("report on the current pseudo labels",), "all are labelled"
    assert whole.run(Recorder()).data["tables"] == trained.outcomes["pseudo-label"].data["tables"]
    assert whole.plan().steps == ()
    shutil.rmtree(next(labels_of(workspace).glob(f"*/{LABEL}")).parent)
    assert [step.split(" by ")[0] for step in whole.plan().steps] == ["label 1 shape"], "an accepted label is gone"


def test_labels_of_shapes_that_are_gone_are_removed(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    entry = open_dataset(workspace).unlabelled[0]
    index = workspace.prepared / "index.jsonl"
    lines = index.read_text(encoding="utf-8").splitlines(keepends=True)
    index.write_text("".join(line for line in lines if json.loads(line)["source"] != entry.source), encoding="utf-8")
    replace(trained.stages["pseudo-label"], workspace=workspace).run(Recorder())  # type: ignore[type-var]
    assert not (labels_of(workspace) / label_name(entry)).exists()
    assert label_name(entry) not in Cache(labels_of(workspace))


def test_outdated_labels_of_other_categories_are_named(trained: Trained, tmp_path: Path) -> None:
    workspace = trained.copy(tmp_path)
    config = workspace.models / CONFIG
    table = json.loads(config.read_text(encoding="utf-8"))
    table["refinement"]["doubt"] += 0.01
    config.write_text(json.dumps(table), encoding="utf-8")
    others = sorted({row[0] for row in trained.outcomes["pseudo-label"].data["tables"][0]["rows"]} - {"Pliers", "all"})
    text = PseudoLabel(workspace, "pliers", device="cpu").run(Recorder()).text
    assert f" Labels of {', '.join(others)} are outdated: run kinmo pseudo-label to update them." in text
    assert "outdated" not in PseudoLabel(workspace, device="cpu").run(Recorder()).text


def test_a_refused_shape_is_not_labelled_again(trained: Trained, tmp_path: Path) -> None:
    stage = PseudoLabel(trained.copy(tmp_path), threshold=1.0, device="cpu")
    assert "Accepted 0 of" in stage.run(Recorder()).text
    assert stage.plan().steps == ()
    recorder = Recorder()
    stage.run(recorder)
    assert recorder.notes == ["already labelled"] and not recorder.steps


def test_an_unknown_method_is_refused(trained: Trained) -> None:
    with pytest.raises(InputError, match="expected one of kinmo, paper, got magic"):
        PseudoLabel(trained.workspace, method="magic").plan()


@pytest.mark.parametrize("method", METHODS)
def test_predictions_do_not_depend_on_the_annotation(method: str, trained: Trained) -> None:
    """Oracle labels may therefore be compared with predictions for the same files."""
    predictor = load_method(method, ModelFolder(trained.workspace.models), "cpu")
    store = PreparedStore(trained.workspace.prepared)
    for entry in [entry for entry in store.entries if entry.joint_count][:6]:
        shape = store.load(entry)
        meshes = leaf_meshes(ShapeSource.of(shape).read(), shape)
        bare = replace(shape, mobility=None, body_boxes=None, body_types={}, edge_labels=None)
        with_labels, without = (predictor.predict(each, meshes).mobility for each in (shape, bare))
        assert [body.leaves for body in with_labels.bodies] == [body.leaves for body in without.bodies]
        for one, other in zip(with_labels.bodies, without.bodies, strict=True):
            assert (one.parent, one.joint is None) == (other.parent, other.joint is None)
            if one.joint is not None and other.joint is not None:
                assert one.joint.kind is other.joint.kind
                assert one.joint.direction == pytest.approx(other.joint.direction)
                assert one.joint.pivot == pytest.approx(other.joint.pivot)
