"""From labelled and pseudo-labelled shapes to networks that see scans, their tables, and a user's scan."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import torch
from whole_road import Listener, contents, tiny_config

from kinmo.errors import InputError
from kinmo.learning.ancsh.predict import POINTS_TO_ASK_ABOUT
from kinmo.pipeline.ancsh_files import Cell, scores_path, trained_cells
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.evaluate import Evaluate
from kinmo.pipeline.evaluate_all import EvaluateAll
from kinmo.pipeline.evaluate_scans import EvaluateScans
from kinmo.pipeline.predict_scan import PredictScan
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.pseudo_label import folder_name
from kinmo.pipeline.render import Render
from kinmo.pipeline.report import Report
from kinmo.pipeline.scan_dataset import ROLES, open_scan_dataset, scans_of
from kinmo.pipeline.scan_jobs import REFUSED
from kinmo.pipeline.scan_report import OUTDATED
from kinmo.pipeline.scan_table_rows import TABLES, printed_row
from kinmo.pipeline.scan_tables import JudgeTrained, MakeTable
from kinmo.pipeline.synth import Synth
from kinmo.pipeline.train_all import TrainAll
from kinmo.pipeline.train_ancsh import TrainAncsh
from kinmo.pipeline.written_scan_tables import WrittenTables
from kinmo.scans.scan_file import ScanFile, count_objects, open_scans
from kinmo.store import read_header
from kinmo.synth.generate import HELD_BACK
from kinmo.workspace import Workspace

FAMILY, CATEGORY = "laptop", "Laptop"
SCANS = """
[ancsh]
points = 128
centers = [32, 8]
neighbours = 8
width = 0.125
batch_frames = 4
batches_per_epoch = 2
confidence = 0.0
[ancsh.training]
epochs = 1
learning_rate = 1e-3
weight_decay = 0.0
decay_epochs = 0
threads = 1
[scans]
states = 2
views = 2
test_states = 1
test_views = 2
size = 96
points = 256
least_pixels = 1
"""
HOW = {"device": "cpu"}


@dataclass
class Scanned:
    """A workspace with scans, and the configuration that they were made with."""

    workspace: Workspace
    config: str

    def render(self, **options: object) -> Render:
        return Render(self.workspace, self.config, FAMILY, **options)  # type: ignore[arg-type]

    def train(self, setting: str) -> TrainAncsh:
        return TrainAncsh(self.workspace, self.config, FAMILY, setting, **HOW)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scanned]:
    folder = tmp_path_factory.mktemp("scans")
    config = tiny_config(folder)
    others, _ = config.read_text(encoding="utf-8").split("[ancsh]\n")
    config.write_text(others + SCANS, encoding="utf-8")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    Synth(folder / "partnet", 6, (FAMILY,), ("partnet_mobility", "partnet"), held_back=True).run(Listener())
    workspace = Workspace(folder / "workspace")
    Prepare(folder / "partnet", workspace, hold_back=(folder / "partnet" / HELD_BACK,)).run(Listener())
    made = Scanned(workspace, str(config))
    made.render(unlabelled=True).run(Listener())
    made.train("supervised").run(Listener())
    yield made
    torch.set_num_threads(threads)


def test_every_object_has_one_role_and_its_frames(scanned: Scanned) -> None:
    dataset = open_scan_dataset(scanned.workspace, CATEGORY.lower())
    assert dataset.category == CATEGORY
    assert str(dataset.structure) == "2 parts (R on 0)"
    for role, frames in (("train", 4), ("hidden", 4), ("unlabelled", 2), ("validation", 2), ("test", 2)):
        assert dataset.files[role], role
        drawn = Counter[str]()
        for file in dataset.files[role]:
            drawn[file.id] += file.frames + sum(file.refused.values())
        assert set(drawn.values()) == {frames}, role
    labelled = {file.id for role in ("train", "validation", "test") for file in dataset.files[role]}
    assert not labelled & {file.id for file in dataset.files["hidden"]}
    assert {file.id for file in dataset.files["hidden"]} == {file.id for file in dataset.files["unlabelled"]}


def test_objects_to_train_on_are_scanned_with_others_like_them_and_count_once(scanned: Scanned) -> None:
    dataset = open_scan_dataset(scanned.workspace, CATEGORY)
    for role, count in (("train", 2), ("hidden", 2), ("unlabelled", 1), ("validation", 1), ("test", 1)):
        by_object: dict[str, list[ScanFile]] = {}
        for file in dataset.files[role]:
            by_object.setdefault(file.id, []).append(file)
        assert {len(files) for files in by_object.values()} == {count}, role
        assert count_objects(dataset.files[role]) == len(by_object)
        if count == 2:
            assert all(not np.allclose(one.extents.sizes, other.extents.sizes) for one, other in by_object.values())
    report = scanned.render(unlabelled=True).run(Listener()).data["categories"][CATEGORY]
    found = {role: count_objects(dataset.files[role]) for role in ("train", "hidden", "validation", "test")}
    assert {role: report["objects"][role] for role in found} == found


def test_objects_that_stand_in_for_validation_ones_are_seen_as_they_are(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "validation")
    before = open_scan_dataset(scanned.workspace, CATEGORY)
    dataset = open_scan_dataset(Workspace(tmp_path / "workspace"), CATEGORY)
    (chosen,) = dataset.files["validation"]
    assert not chosen.is_variant
    assert {file.id for file in dataset.files["train"]} == {file.id for file in before.files["train"]} - {chosen.id}
    assert any(file.is_variant for file in dataset.files["train"])


def test_objects_that_are_not_closed_have_no_variants(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), tmp_path / "file.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("[scans]", '[scans]\ncanonical = "file"')
    config.write_text(text, encoding="utf-8")
    Render(workspace, str(config), FAMILY).run(Listener())
    files = open_scan_dataset(workspace, CATEGORY).files
    assert not any(file.is_variant for role in ROLES for file in files[role])


def test_what_was_scanned_is_not_scanned_again(scanned: Scanned) -> None:
    before, told = contents(scanned.workspace.path), Listener()
    plan = scanned.render(unlabelled=True).plan()
    assert (plan.steps, plan.seconds) == ((), 0.0)
    scanned.render(unlabelled=True).run(told)
    assert told.notes == ["scanned already"]
    assert contents(scanned.workspace.path) == before


def test_an_object_that_cannot_be_scanned_says_why_and_is_not_tried_again(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    config = tmp_path / "strict.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8") + "smallest_part = 1.0\n", encoding="utf-8")
    stage = Render(Workspace(tmp_path / "workspace"), str(config), FAMILY)
    found = stage.run(Listener())
    assert found.data["refused"]
    assert all("no part of it moves that is large enough" in reason for reason in found.data["refused"].values())
    assert not list((tmp_path / "workspace" / "scans").rglob("*/train/*.safetensors"))
    assert list((tmp_path / "workspace" / "scans").rglob(f"*{REFUSED}"))
    assert stage.plan().steps == ()


def test_scans_of_objects_that_have_gone_go_too(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    folders = [scans_of(workspace, CATEGORY, role) for role in ("train", "pseudo")]
    strays = [folder / "gone-partnet_mobility.safetensors" for folder in folders]
    for stray in strays:
        stray.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(next(folders[0].glob("*.safetensors")), stray)
    Render(workspace, scanned.config, FAMILY).run(Listener())
    assert not any(stray.exists() for stray in strays), "also in a role that no object has any more"


def test_fewer_labels_are_fewer_scans_to_train_on_and_more_that_are_hidden(scanned: Scanned) -> None:
    whole = open_scan_dataset(scanned.workspace, CATEGORY)
    part = open_scan_dataset(Workspace(scanned.workspace.root, 0.3), CATEGORY)
    assert part.structure == whole.structure
    assert part.files["test"] == whole.files["test"] or [f.id for f in part.files["test"]] == [
        f.id for f in whole.files["test"]
    ]
    assert 0 < len(part.files["train"]) < len(whole.files["train"])
    ids = {role: ({f.id for f in whole.files[role]}, {f.id for f in part.files[role]}) for role in ("train", "hidden")}
    assert ids["hidden"][1] == ids["hidden"][0] | (ids["train"][0] - ids["train"][1])


def test_networks_are_trained_once_and_judged_frame_by_frame(scanned: Scanned) -> None:
    told = Listener()
    scanned.train("supervised").run(told)
    assert all("trained already" in note for note in told.notes)
    assert scanned.train("supervised").plan().steps == ()
    cell = Cell(CATEGORY, "supervised", 0)
    assert trained_cells(scanned.workspace) == [cell]
    stage = EvaluateScans(scanned.workspace, cell, "cpu")
    stage.run(Listener())
    assert stage.plan().steps == ()
    dataset = open_scan_dataset(scanned.workspace, CATEGORY)
    lines = scores_path(scanned.workspace, cell, on_rough=False).read_text().splitlines()
    assert len(lines) == sum(file.frames for file in dataset.files["test"])


def test_networks_that_label_scans_are_trained_first_and_their_labels_are_used(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    config = tmp_path / "longer.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    config.write_text(text.replace("learning_rate = 1e-3", "learning_rate = 1e-2"), encoding="utf-8")
    stage = TrainAncsh(workspace, str(config), FAMILY, "semi", **HOW)
    told = Listener()
    stage.run(told)
    assert stage.plan().steps == ()
    header = json.loads((Cell(CATEGORY, "semi", 0).folder(workspace, "ancsh") / "weights.json").read_text())
    dataset = open_scan_dataset(workspace, CATEGORY)
    labelled = sorted((workspace.own_scans / CATEGORY / "semi-0").glob("*.safetensors"))
    assert labelled
    assert header["facts"]["objects"] == count_objects(dataset.files["train"]) + len(labelled)
    assert {open_scans(path).structure for path in labelled} <= {dataset.structure}
    before = contents(workspace.path)
    stage.run(Listener())
    assert contents(workspace.path) == before


def test_a_setting_without_anything_of_its_own_is_none(scanned: Scanned) -> None:
    for setting, what in (("semi-weakly", "run kinmo pseudo-label and kinmo render first"), ("dsg-net", "DSG-Net")):
        with pytest.raises(InputError, match=what):
            scanned.train(setting).plan()


def test_a_cell_that_cannot_be_run_leaves_the_others(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    told = Listener()
    stage = MakeTable("4", Workspace(tmp_path / "workspace"), scanned.config, "kinmo", FAMILY, 1, **HOW)
    found = stage.run(told)
    assert found.failed == 1
    assert [note for note in told.notes if note.startswith(f"not run: {CATEGORY}, dsg-net") and "DSG-Net" in note]
    run = {row[0]: row[1] for row in found.data[CATEGORY]["parts"]["rows"]}
    assert run == {"supervised": "1", "generated shapes": "not run"}


def test_objects_that_stand_in_for_validation_ones_are_the_same_for_all_shares_of_labels(
    scanned: Scanned, tmp_path: Path
) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "validation")
    found = set()
    for share in (1.0, 0.5, 0.1):
        dataset = open_scan_dataset(Workspace(tmp_path / "workspace", share), CATEGORY)
        ids = {role: {file.id for file in dataset.files[role]} for role in ("train", "validation", "hidden")}
        assert ids["train"]
        assert not ids["validation"] & ids["hidden"]
        assert len(ids["train"]) == 1 or not ids["validation"] & ids["train"]
        found.add(frozenset(ids["validation"]))
    (same,) = found
    assert same


def test_scans_by_a_pseudo_label_are_made_anew_when_the_label_or_the_shape_changes(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    dataset = open_dataset(workspace, FAMILY)
    sources = {shape.id: shape.source for shape in dataset.hidden}
    (entry, *_) = dataset.unlabelled
    folder = workspace.pseudo / folder_name(entry)
    shutil.copytree(sources[dataset.truths[entry.id, entry.layout]], folder)
    stage = Render(workspace, scanned.config, FAMILY)
    assert len(stage.plan().steps) == 1
    stage.run(Listener())
    assert stage.plan().steps == ()
    (of_it, *_) = open_scan_dataset(workspace, CATEGORY).files["pseudo"]
    assert of_it.id == entry.id, "whatever its folder is called"
    label = folder / "mobility_v2.json"
    label.write_text(label.read_text(encoding="utf-8") + " ", encoding="utf-8")
    assert len(stage.plan().steps) == 1
    stage.run(Listener())
    prepared = workspace.prepared / entry.file
    made_from = read_header(prepared)["provenance"]["made_from"].encode()
    prepared.write_bytes(prepared.read_bytes().replace(made_from, b"f" * len(made_from)))
    assert len(stage.plan().steps) == 1


def test_without_motion_networks_the_tables_of_scans_are_there_alone(scanned: Scanned) -> None:
    shapes = Evaluate(scanned.workspace, ("kinmo", "paper"), FAMILY)
    stage, told = EvaluateAll(shapes, JudgeTrained(scanned.workspace, FAMILY, device="cpu")), Listener()
    found = stage.run(told)
    assert list(found.data) == ["table-2"]
    assert [note for note in told.notes if note.startswith("no Table 1:")]


def test_a_table_shows_what_was_not_run_and_the_authors_figures(scanned: Scanned) -> None:
    EvaluateScans(scanned.workspace, Cell(CATEGORY, "supervised", 0), "cpu").run(Listener())
    found = WrittenTables(scanned.workspace, "2").of(CATEGORY, (0,))
    run = {row[0]: row[1] for row in found["parts"].rows}
    assert run["semi"] == run["semi-weakly"] == run["true labels"] == "not run"
    assert run["supervised"] == "1"
    assert printed_row("2", "fridge", "ANCSH") is None
    assert printed_row("2", "refrigerator", "ANCSH")[0] == [12.09, 18.43, 21.7]
    assert printed_row("4", "StorageFurniture", "ANCSH (DSG)")[0] == [40.0, 45.5, 42.0]
    for name, table in TABLES.items():
        for row in table.rows:
            assert not row.printed or all(printed_row(name, category, row.printed) for category in table.categories)


def test_a_table_says_how_right_pseudo_labels_are_where_true_ones_are_held_back(scanned: Scanned, tmp_path: Path) -> None:
    JudgeTrained(scanned.workspace, FAMILY, device="cpu").run(Listener())
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    written = WrittenTables(workspace, "2")
    supervised, weakly = (scores_path(workspace, Cell(CATEGORY, name, 0), False) for name in ("supervised", "semi-weakly"))
    hidden, pseudo = (scans_of(workspace, CATEGORY, role) for role in ("hidden", "pseudo"))
    for is_run in (False, True):
        if is_run:
            shutil.copy(supervised, weakly)
            shutil.copytree(hidden, pseudo)
        written.write({CATEGORY: [0]})
        text = (written.folder / CATEGORY / "means.md").read_text(encoding="utf-8")
        count = count_objects(open_scan_dataset(workspace, CATEGORY).files["hidden"])
        labels = f"Of {count} objects that pseudo labels give these joints {count} truly have them, {count} all in"
        assert (labels in " ".join(text.split())) is is_run


def test_what_is_trained_is_judged_where_there_are_scans_of_it(scanned: Scanned) -> None:
    stage = JudgeTrained(scanned.workspace, FAMILY, device="cpu")
    found = stage.run(Listener())
    assert list(found.data) == ["table-2"], "no rough scans, and no category of the other tables"
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    assert list(found.data["table-2"]) == [CATEGORY]


def test_the_report_says_that_figures_of_scans_are_outdated(scanned: Scanned, tmp_path: Path) -> None:
    JudgeTrained(scanned.workspace, FAMILY, device="cpu").run(Listener())
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    page = workspace.report / "index.html"
    Report(workspace).run(Listener())
    assert "Table 2, poses" in page.read_text(encoding="utf-8")
    assert OUTDATED not in page.read_text(encoding="utf-8")
    weights, _ = Cell(CATEGORY, "supervised", 0).weights(workspace) or pytest.fail("not trained")
    header = weights.with_suffix(".json")
    header.write_text(json.dumps(json.loads(header.read_text()) | {"sha256": "of others"}))
    Report(workspace).run(Listener())
    assert OUTDATED in page.read_text(encoding="utf-8")


def test_a_category_without_test_objects_is_said_to_be_not_judged(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "test")
    stage, told = JudgeTrained(Workspace(tmp_path / "workspace"), FAMILY, device="cpu"), Listener()
    assert stage.plan().steps == ()
    stage.run(told)
    assert [note for note in told.notes if "not judged" in note and "expected scans of a test object" in note]


def test_without_time_no_cell_is_run_and_all_are_told(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "eval", ignore_errors=True)
    told = Listener()
    stage = MakeTable("2", Workspace(tmp_path / "workspace"), scanned.config, "kinmo", FAMILY, 1, hours=0.0, **HOW)
    found = stage.run(told)
    assert sum(note.startswith("not run") for note in told.notes) == len(TABLES["2"].rows)
    assert (found.path / CATEGORY / "parts.md").exists()
    assert {row[1] for row in found.data[CATEGORY]["parts"]["rows"]} == {"not run"}


def test_a_table_whose_motion_networks_have_none_to_go_on_from_says_so(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, told = Workspace(tmp_path / "workspace"), Listener()
    stage = MakeTable("4", workspace, scanned.config, "kinmo", FAMILY, 1, start=Workspace(tmp_path / "none"), **HOW)
    assert stage.run(told).failed == 1
    (problem,) = (note for note in told.notes if note.startswith("not run"))
    assert "generated" not in problem
    assert str(tmp_path / "none") in problem
    assert "expected the weights to go on from" in problem


def test_train_all_goes_the_whole_way_once(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, "kinmo", FAMILY, **HOW)
    steps = " ".join(stage.plan().steps)
    for step in ("gnn_fine", "gnn_coarse", "axis", "ranking", "label", "scan", "ancsh"):
        assert step in steps, "said before anything is done"
    told = Listener()
    found = stage.run(told)
    assert [note for note in told.notes if note.startswith("to do")]
    # such networks find nothing that moves, so that there are no pseudo labels to learn from
    assert {"gnn_fine", f"ancsh ({CATEGORY}, supervised, seed 0)"} <= found.data.keys()
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    before = contents(tmp_path / "workspace")
    stage.run(Listener())
    assert contents(tmp_path / "workspace") == before


def test_without_a_category_of_the_papers_train_all_says_that_scans_are_left_out(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, "kinmo", **HOW)
    assert "ancsh" not in " ".join(stage.plan().steps)
    with pytest.raises(InputError, match="expected a labelled shape of safe to train on"):
        TrainAll(Workspace(tmp_path / "workspace"), scanned.config, "kinmo", "safe", **HOW).plan()


def test_a_users_scan_gives_parts_joints_and_a_picture(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=points)
    found = PredictScan(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW).run(Listener())
    document = json.loads((tmp_path / "out" / "seen.json").read_text())
    assert document == found.data
    assert [joint["kind"] for joint in document["joints"]] == ["R"]
    assert sum(part["points"] for part in document["parts"]) == POINTS_TO_ASK_ABOUT
    assert (tmp_path / "out" / "seen.svg").read_text().startswith("<svg")


def test_a_category_without_networks_is_named_with_those_that_there_are(scanned: Scanned, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no networks that find a labtop in scans.*Laptop"):
        PredictScan(tmp_path / "x.npz", tmp_path, scanned.workspace, "labtop").run(Listener())
    with pytest.raises(InputError, match="run kinmo render first"):
        TrainAncsh(Workspace(scanned.workspace.root), scanned.config, "safe").run(Listener())
