"""Training of networks for scans, on true labels and on pseudo labels."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from scanned_workspace import CATEGORY, CPU, FAMILY, Scanned, copy_oracle_labels, with_pseudo_labels
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
from kinmo.io.readers import DSG_NET
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.example_scan import ExampleScan
from kinmo.pipeline.scans.predict_scans import PredictScans
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_networks import ScanRun, trained_runs
from kinmo.pipeline.scans.scan_scores import ScanScores
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.files.scan_file import ROLES, count_objects
from kinmo.view.scan_sections import picture_sections

SUPERVISED = ScanRun(CATEGORY, "supervised", 0)


def counts_trained_on(made: Scanned, run: ScanRun) -> tuple[int, int]:
    """Numbers of labelled and of other objects in the header of a network."""
    facts = json.loads((run.folder(made.workspace, "npcs") / "weights.json").read_text(encoding="utf-8"))["facts"]
    return facts["labelled"], facts["objects"] - facts["labelled"]


def test_networks_are_trained_once_and_scored_frame_by_frame(scanned: Scanned) -> None:
    observer = Recorder()
    scanned.train().run(observer)
    assert observer.notes and all("already trained" in note for note in observer.notes)
    assert scanned.train().plan().steps == ()
    assert trained_runs(scanned.workspace) == [SUPERVISED]
    scores = ScanScores(scanned.workspace, SUPERVISED)
    stage = EvaluateScans(scores, "cpu")
    stage.run(Recorder())
    assert stage.plan().steps == ()
    dataset = open_scan_dataset(scanned.workspace, CATEGORY)
    lines = scores.path("kinmo").read_text(encoding="utf-8").splitlines()
    assert len(lines) == sum(file.frames for file in dataset.files["test"])
    again = Recorder()
    stage.run(again)
    assert again.notes == [f"{SUPERVISED}: already evaluated"]


@pytest.mark.parametrize("threads", [0, 1])
def test_the_estimate_is_the_same_before_there_are_scans(scanned: Scanned, tmp_path: Path, threads: int) -> None:
    text, config = Path(scanned.config).read_text(encoding="utf-8"), tmp_path / "threads.toml"
    others, own = text.split("[ancsh]\n")
    config.write_text(f"{others}[ancsh]\n{own.replace('threads = 1', f'threads = {threads}')}", encoding="utf-8")
    stages = [
        TrainScans(scanned.workspace, str(config), FAMILY, "supervised", seed=1, device="cpu", workers=workers)
        for workers in (1, 2)
    ]
    alone, together = (stage.plan().seconds for stage in stages)
    assert [stage.guess().seconds for stage in stages] == [alone, together]
    assert (together < alone) is (threads == 1), "with all threads, one network is trained at a time"


def test_networks_learn_from_pseudo_labels_too(scanned: Scanned, tmp_path: Path) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    made.render().run(Recorder())
    stage = made.train("semi-weakly")
    stage.run(Recorder())
    assert stage.plan().steps == ()
    budgets = [[(task.work.schedule, task.work.units) for task in own._tasks()] for own in (stage, made.train())]
    assert budgets[0] == budgets[1], "as many steps on as many frames, whatever the number of labels"
    files = open_scan_dataset(made.workspace, CATEGORY).files
    counts = counts_trained_on(made, ScanRun(CATEGORY, "semi-weakly", 0))
    assert counts == (count_objects(files["train"]), count_objects(files["pseudo"]))
    assert counts[1] > 0


def test_networks_learn_from_generated_shapes_if_there_are_no_other_pseudo_labels(scanned: Scanned, tmp_path: Path) -> None:
    made, labels = with_pseudo_labels(scanned, tmp_path, DSG_NET)
    made.render().run(Recorder())
    later = TrainAll(made.workspace, made.config, FAMILY, **CPU)._later(open_dataset(made.workspace))
    (training,) = (stage for stage in later if isinstance(stage, TrainScans))
    assert training.setting == "semi-weakly"
    training.run(Recorder())
    labelled = count_objects(open_scan_dataset(made.workspace, CATEGORY).files["train"])
    assert counts_trained_on(made, ScanRun(CATEGORY, "semi-weakly", 0)) == (labelled, len(labels))


def test_scans_of_an_interrupted_self_labelling_are_not_trained_on(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    folder = made.workspace.scans / CATEGORY / "self-labels-0"
    folder.mkdir()
    path = next(made.scans("train"))
    shutil.copy(path, folder)
    with pytest.raises(InputError, match="self-training: needs scans of objects that the supervised networks are sure of"):
        made.train("self-training").plan()


def test_each_method_has_pseudo_labels_scans_and_networks_of_its_own(scanned: Scanned, tmp_path: Path) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    workspace = made.workspace
    copy_oracle_labels(workspace, "paper", count=1)
    for method in ("kinmo", "paper"):
        made.render(method=method).run(Recorder())
        TrainScans(workspace, made.config, FAMILY, "semi-weakly", method, **CPU).run(Recorder())
    known, others = (open_scan_dataset(workspace, CATEGORY, method).files for method in ("kinmo", "paper"))
    assert count_objects(known["pseudo"]) > count_objects(others["pseudo"]) == 1
    for role in set(ROLES) - {"pseudo"}:
        assert [file.path for file in known[role]] == [file.path for file in others[role]], role
    table = EvaluateTrained(workspace, FAMILY, device="cpu").run(Recorder()).data["table-2"][CATEGORY]["means"]
    trained = {row[0]: row[1] for row in table["rows"] if row[2] == "0"}
    assert trained["semi-weakly"] != trained["semi-weakly, paper"] == f"{trained['supervised']} + 1"
    assert {"semi-weakly, paper against supervised", "semi-weakly against semi-weakly, paper"} <= {
        row[0] for row in table["rows"]
    }
    shown = [picture.title for section in picture_sections(workspace) for picture in section.pictures]
    assert {title.split(":")[0] for title in shown} >= {"supervised", "semi-weakly", "semi-weakly, paper"}
    example = ExampleScan(workspace, FAMILY, tmp_path / "scan.npz", made.render())
    example.run(Recorder())

    def networks_for(method: str | None) -> str:
        stage = PredictScans(example.path, tmp_path / "out", workspace, FAMILY, method=method, **CPU)
        return str(stage.run(Recorder()).data["trained"])

    assert networks_for(None) == networks_for("kinmo") == f"{CATEGORY}, semi-weakly, seed 0"
    assert networks_for("paper") == f"{CATEGORY}, semi-weakly, seed 0, labels by paper"
    shutil.rmtree(workspace.models / "ancsh" / CATEGORY / "semi-weakly-kinmo")
    shutil.rmtree(workspace.models / "ancsh" / CATEGORY / "supervised")
    assert networks_for(None) == networks_for("paper"), "there are no other networks"
