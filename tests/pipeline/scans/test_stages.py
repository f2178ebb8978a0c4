"""From labelled and pseudo-labelled shapes to networks that see scans, and a user's scan."""

from __future__ import annotations

import json
import math
import re
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scan_road import CATEGORY, FAMILY, HOW, SCANS, Scanned, prepared_in
from typer.testing import CliRunner
from whole_road import Listener, contents

from kinmo.cli.app import app
from kinmo.config import load_config
from kinmo.errors import InputError
from kinmo.pipeline import each_shape
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.label_decisions import folder_name
from kinmo.pipeline.scans.dataset import open_scan_dataset, scans_of
from kinmo.pipeline.scans.evaluate import EvaluateScans
from kinmo.pipeline.scans.example import ExampleScan
from kinmo.pipeline.scans.finder import ScanFinder
from kinmo.pipeline.scans.judge_trained import JudgeTrained
from kinmo.pipeline.scans.networks import Cell, scores_path, trained_cells
from kinmo.pipeline.scans.predict import PredictScans
from kinmo.pipeline.scans.refusal import REFUSED
from kinmo.pipeline.scans.render import USED, Render
from kinmo.pipeline.scans.report import picture_sections
from kinmo.pipeline.scans.self_label import SelfLabel
from kinmo.pipeline.scans.train import TrainAncsh
from kinmo.pipeline.scans.written_tables import WrittenTables
from kinmo.pipeline.train_all import TrainAll
from kinmo.scans.articulation import opening
from kinmo.scans.renderers import NOTHING
from kinmo.scans.scan_file import ROLES, ScanFile, count_objects, open_scans
from kinmo.scans.scan_input import read_scan
from kinmo.splits import Split
from kinmo.store import INDEX, read_header
from kinmo.workspace import Workspace


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
    report = scanned.render(beside=ROLES).run(Listener()).data["categories"][CATEGORY]
    found = {role: count_objects(dataset.files[role]) for role in ("train", "hidden", "validation", "test")}
    assert {role: report["objects"][role] for role in found} == found


def test_the_papers_ways_go_the_whole_road(tmp_path: Path) -> None:
    made = prepared_in(tmp_path, count=4)
    sizes = SCANS.replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    Path(made.config).write_text(f'extends = "paper"\n{sizes}', encoding="utf-8")
    config = load_config(made.config)
    assert (config.scans.renderer, config.scans.canonical, config.scans.sampling) == ("pybullet", "file", "release")
    assert (config.ancsh.axes, config.ancsh.normalised, config.ancsh.ties) == ("camera", "object", "pairs")
    assert not (config.ancsh.maps or config.ancsh.layout)
    made.render().run(Listener())
    made.train("supervised").run(Listener())
    JudgeTrained(made.workspace, FAMILY, device="cpu").run(Listener())
    (row, *_) = WrittenTables(made.workspace, "2").write({CATEGORY: [0]}, "ancsh").data[CATEGORY]["means"]["rows"]
    assert row[0] == "supervised"
    assert 0.0 < row[3] < 180.0, "degrees"


def test_objects_that_stand_in_for_validation_ones_are_seen_as_they_are(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "validation")
    before = open_scan_dataset(scanned.workspace, CATEGORY)
    dataset = open_scan_dataset(Workspace(tmp_path / "workspace"), CATEGORY)
    (chosen,) = dataset.files["validation"]
    assert not chosen.provenance.variant
    assert {file.id for file in dataset.files["train"]} == {file.id for file in before.files["train"]} - {chosen.id}
    assert any(file.provenance.variant for file in dataset.files["train"])


def test_objects_that_are_not_closed_have_no_variants(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), tmp_path / "file.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("[scans]", '[scans]\ncanonical = "file"')
    config.write_text(text, encoding="utf-8")
    Render(workspace, str(config), FAMILY).run(Listener())
    files = open_scan_dataset(workspace, CATEGORY).files
    assert not any(file.provenance.variant for role in ROLES for file in files[role])


def test_what_was_scanned_is_not_scanned_again(scanned: Scanned) -> None:
    before, told = contents(scanned.workspace.path), Listener()
    plan = scanned.render(beside=ROLES).plan()
    assert (plan.steps, plan.seconds) == ((), 0.0)
    scanned.render(beside=ROLES).run(told)
    assert told.notes == ["scanned already"]
    assert contents(scanned.workspace.path) == before


def test_only_what_is_asked_for_is_scanned_beside_the_labelled_objects(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    shutil.rmtree(workspace.scans)
    shutil.rmtree(workspace.own_scans, ignore_errors=True)
    labelled = {"train", "validation", "test"}
    for beside, roles in (((), labelled), (("hidden",), labelled | {"hidden"}), (("unlabelled",), {*labelled, "unlabelled"})):
        found = Render(workspace, scanned.config, FAMILY, beside=beside).run(Listener())
        assert set(found.data["categories"][CATEGORY]["objects"]) == roles
    assert open_scan_dataset(workspace, CATEGORY).files["hidden"], "what is not asked for stays"


def test_an_object_that_cannot_be_scanned_says_why_and_is_not_tried_again(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    config = tmp_path / "strict.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8") + "smallest_part = 1.0\n", encoding="utf-8")
    stage = Render(Workspace(tmp_path / "workspace"), str(config), FAMILY)
    found = stage.run(Listener())
    reasons = {role: list(by_id.values()) for role, by_id in found.data["refused"].items()}
    assert {"train", "hidden"} <= set(reasons), "whatever role an object has"
    assert all("no part of it moves that is large enough" in reason for own in reasons.values() for reason in own)
    assert found.text.count("left out") == sum(map(len, reasons.values()))
    assert not list((tmp_path / "workspace" / "scans").rglob("*/train/*.safetensors"))
    assert list((tmp_path / "workspace" / "scans").rglob(f"*{REFUSED}"))
    assert stage.plan().steps == ()


def test_frames_that_show_too_little_are_counted_with_the_reason(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    config = tmp_path / "strict.toml"
    text = Path(scanned.config).read_text(encoding="utf-8")
    config.write_text(text.replace("least_pixels = 1\n", "least_pixels = 100000\n"), encoding="utf-8")
    found = Render(Workspace(tmp_path / "workspace"), str(config), FAMILY, beside=()).run(Listener())
    refused = found.data["categories"][CATEGORY]["refused"]
    assert sum(refused.values()) > 0
    for reason, count in refused.items():
        assert f"{count} {reason}" in found.text and "fewer than 100000 pixels" in reason


def test_an_object_that_cannot_be_read_now_is_scanned_once_it_can(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    shutil.rmtree(workspace.scans)
    (entry, *_) = open_dataset(workspace, FAMILY).hidden
    source, away = Path(entry.source), tmp_path / "away"
    stage = Render(workspace, scanned.config, FAMILY)
    source.rename(away)
    try:
        found = stage.run(Listener())
        assert stage.plan().steps == (), "nothing waits for what has gone"
    finally:
        away.rename(source)
    assert found.failed == 1
    assert list(found.data["refused"]["hidden"]) == [entry.id] and "result.json: missing" in found.text
    assert not list(workspace.scans.rglob(f"*{REFUSED}"))
    assert len(stage.plan().steps) == 1
    assert stage.run(Listener()).failed == 0
    assert entry.id in {file.id for file in open_scan_dataset(workspace, CATEGORY).files["hidden"]}


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


def test_what_is_to_be_scanned_anew_is_gone_before_that_begins(scanned: Scanned, tmp_path: Path) -> None:
    class CutOff(Listener):
        def progress(self, *_: object) -> None:
            raise KeyboardInterrupt

    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), tmp_path / "other.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8").replace("size = 96", "size = 80"), encoding="utf-8")
    with pytest.raises(KeyboardInterrupt):
        Render(workspace, str(config), FAMILY).run(CutOff())
    left = [open_scans(path) for path in workspace.path.rglob("scans/**/*.safetensors")]
    assert {file.object for file in left} == {left[0].object}, "the one that was done, of all roles"
    assert all(len(file.read("points")) > 0 for file in left)


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


def test_networks_that_label_scans_are_trained_first_and_their_labels_are_used(
    scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    config = tmp_path / "longer.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("batches_per_epoch = 2", "batches_per_epoch = 60")
    config.write_text(text.replace("learning_rate = 1e-3", "learning_rate = 1e-2"), encoding="utf-8")
    stage = TrainAncsh(workspace, str(config), FAMILY, "semi", **HOW)
    planned = stage.plan()
    assert [step.split(" (")[0] for step in planned.steps if step.startswith("train")] == ["train ancsh", "train npcs"] * 2
    assert [step for step in planned.steps if step.startswith("label")]
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
    own, gone = SelfLabel(workspace, CATEGORY, confidence=0.0, **HOW), labelled[0].read_bytes()
    assert own.plan().steps == ()
    workspace.forget(f"self-label-{CATEGORY}-0")  # as if it had been killed before the first one was done
    labelled[0].unlink()
    kept = {path: path.stat().st_mtime_ns for path in labelled[1:]}
    assert len(own.plan().steps) == 1
    own.run(Listener())
    assert {path: path.stat().st_mtime_ns for path in labelled[1:]} == kept, "what was labelled stays as it is"
    assert labelled[0].read_bytes() == gone
    monkeypatch.setattr(each_shape, "JOBS_A_PROCESS", 1)
    by_one = contents(labelled[0].parent)
    workspace.forget(f"self-label-{CATEGORY}-0")
    for path in labelled:
        path.unlink()
    replace(own, workers=2).run(Listener())
    assert contents(labelled[0].parent) == by_one, "by two processes too"


def test_a_setting_without_anything_of_its_own_is_none(scanned: Scanned) -> None:
    for setting, objects in (("semi-weakly", "objects"), ("dsg-net", "objects in DSG-Net's layout")):
        problem = f"{setting}: needs scans of pseudo-labelled {objects} with 2 parts (revolute on part 0), and there are none"
        with pytest.raises(InputError, match=re.escape(f"{problem}: run kinmo pseudo-label, then kinmo render")):
            scanned.train(setting).plan()


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


def pseudo_labelled(scanned: Scanned, folder: Path, layout: str = "partnet") -> tuple[Workspace, list[Path]]:
    """The workspace copied to `folder`, its unlabelled shapes given the labels that were held back, and these labels.

    The unlabelled shapes are said to have come in a `layout`.
    """
    shutil.copytree(scanned.workspace.path, folder)
    index = folder / "prepared" / INDEX
    index.write_text(index.read_text(encoding="utf-8").replace('"partnet",', f'"{layout}",'), encoding="utf-8")
    workspace = Workspace(folder)
    dataset = open_dataset(workspace, FAMILY)
    sources = {shape.id: shape.source for shape in dataset.hidden}
    folders = [workspace.pseudo / folder_name(entry) for entry in dataset.unlabelled]
    for entry, target in zip(dataset.unlabelled, folders, strict=True):
        shutil.copytree(sources[dataset.truths[entry.id, entry.layout]], target)
    return workspace, [target / "mobility_v2.json" for target in folders]


def test_scans_by_a_pseudo_label_are_made_anew_when_the_label_or_the_shape_changes(scanned: Scanned, tmp_path: Path) -> None:
    workspace, (label, *_) = pseudo_labelled(scanned, tmp_path / "workspace")
    stage = Render(workspace, scanned.config, FAMILY)
    assert len(stage.plan().steps) == 1
    stage.run(Listener())
    assert stage.plan().steps == ()
    (entry, *_) = open_dataset(workspace, FAMILY).unlabelled
    scanned_ids = {file.id for file in open_scan_dataset(workspace, CATEGORY).files["pseudo"]}
    assert entry.id in scanned_ids, "whatever its folder is called"
    label.write_text(label.read_text(encoding="utf-8") + " ", encoding="utf-8")
    assert len(stage.plan().steps) == 1
    stage.run(Listener())
    prepared = workspace.prepared / entry.file
    made_from = read_header(prepared)["provenance"]["made_from"].encode()
    prepared.write_bytes(prepared.read_bytes().replace(made_from, b"f" * len(made_from)))
    assert len(stage.plan().steps) == 1


def test_scans_by_pseudo_labels_wait_for_those_that_show_how_far_hinges_open(scanned: Scanned, tmp_path: Path) -> None:
    workspace, _ = pseudo_labelled(scanned, tmp_path / "workspace")
    stage = Render(workspace, scanned.config, FAMILY)
    entry = open_dataset(workspace, FAMILY).labelled[Split.TRAIN][0]
    for path in scans_of(workspace, CATEGORY, "train").glob(f"{entry.id}-*"):
        path.unlink()
    source, away = Path(entry.source), tmp_path / "away"
    source.rename(away)
    try:
        assert stage.run(Listener()).failed == 1
    finally:
        away.rename(source)
    assert not open_scan_dataset(workspace, CATEGORY).files["pseudo"]
    assert stage.run(Listener()).failed == 0
    assert open_scan_dataset(workspace, CATEGORY).files["pseudo"]
    assert stage.plan().steps == ()


def test_hinges_whose_end_a_pseudo_label_does_not_know_open_as_far_as_labelled_ones(scanned: Scanned, tmp_path: Path) -> None:
    workspace, labels = pseudo_labelled(scanned, tmp_path / "workspace")
    for label in labels:
        bodies = json.loads(label.read_text(encoding="utf-8"))
        for body in bodies:
            if body["joint"] == "hinge":
                body["jointData"]["limit"] |= {"a": -90.0, "b": 90.0, "noLimit": False}
        label.write_text(json.dumps(bodies), encoding="utf-8")
    Render(workspace, scanned.config, FAMILY).run(Listener())
    files = open_scan_dataset(workspace, CATEGORY).files
    usual = [max(opening(file.joints[0]) or 0.0, math.pi / 2) for file in files["train"]]
    assert files["pseudo"]
    for file in files["pseudo"]:
        assert opening(file.joints[0]) in [pytest.approx(known) for known in usual]


def test_networks_learn_from_pseudo_labels_too(scanned: Scanned, tmp_path: Path) -> None:
    workspace, _ = pseudo_labelled(scanned, tmp_path / "workspace")
    Render(workspace, scanned.config, FAMILY).run(Listener())
    stage = TrainAncsh(workspace, scanned.config, FAMILY, "semi-weakly", **HOW)
    stage.run(Listener())
    assert stage.plan().steps == ()
    dataset = open_scan_dataset(workspace, CATEGORY)
    config = load_config(scanned.config)
    others = TrainAncsh(workspace, scanned.config, FAMILY, "supervised", **HOW)
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
    Render(workspace, scanned.config, FAMILY).run(Listener())
    later = TrainAll(workspace, scanned.config, FAMILY, **HOW)._later(open_dataset(workspace))
    (training,) = (stage for stage in later if isinstance(stage, TrainAncsh))
    assert training.setting == "dsg-net"
    training.run(Listener())
    EvaluateScans(workspace, Cell(CATEGORY, "dsg-net", 0), "cpu").run(Listener())
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
        Render(place, scanned.config, FAMILY).run(Listener())
        TrainAncsh(place, scanned.config, FAMILY, "semi-weakly", **HOW).run(Listener())
    known, others = (open_scan_dataset(place, CATEGORY).files for place in (workspace, other))
    assert count_objects(known["pseudo"]) > count_objects(others["pseudo"]) == 1
    for role in set(ROLES) - {"pseudo"}:
        assert [file.path for file in known[role]] == [file.path for file in others[role]], role
    table = JudgeTrained(workspace, FAMILY, device="cpu").run(Listener()).data["table-2"][CATEGORY]["means"]
    trained = {row[0]: row[1] for row in table["rows"] if row[2] == "0"}
    assert trained["semi-weakly"] != trained["semi-weakly, paper"] == f"{trained['supervised']} + 1"
    assert {"semi-weakly, paper against supervised", "semi-weakly against semi-weakly, paper"} <= {
        row[0] for row in table["rows"]
    }
    shown = [picture.title for section in picture_sections(workspace) for picture in section.pictures]
    assert {title.split(":")[0] for title in shown} >= {"supervised", "semi-weakly", "semi-weakly, paper"}
    example = ExampleScan(workspace, FAMILY, tmp_path / "scan.npz", Render(workspace, scanned.config, FAMILY))
    example.run(Listener())

    def trained_for(method: str | None) -> str:
        stage = PredictScans(example.path, tmp_path / "out", workspace, FAMILY, method=method, **HOW)
        return str(stage.run(Listener()).data["trained"])

    assert trained_for(None) == trained_for("kinmo") == f"{CATEGORY}, semi-weakly, seed 0"
    assert trained_for("paper") == f"{CATEGORY}, semi-weakly, seed 0, labels by paper"
    shutil.rmtree(workspace.models / "ancsh")
    assert trained_for(None) == trained_for("paper"), "which is all that there is"


def test_networks_that_know_a_floor_leave_its_points_out(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    config = tmp_path / "floor.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8") + "[scans.sensor]\nfloor = true\n", encoding="utf-8")
    floored = Scanned(Workspace(tmp_path / "workspace"), str(config))
    floored.render(beside=()).run(Listener())
    training = open_scan_dataset(floored.workspace, CATEGORY).files["train"]
    assert all((file.read("parts") == NOTHING).any() for file in training), "the floor is seen, and no part's"
    floored.train("supervised").run(Listener())
    weights = Cell(CATEGORY, "supervised", 0).weights(floored.workspace)
    assert weights is not None
    header = json.loads(weights[0].with_suffix(".json").read_text(encoding="utf-8"))
    known = json.loads(Cell(CATEGORY, "supervised", 0).folder(scanned.workspace, "ancsh").joinpath("weights.json").read_text())
    assert header["facts"]["classes"] == known["facts"]["classes"] + 1
    example = ExampleScan(floored.workspace, FAMILY, tmp_path / "scan.npz", floored.render())
    example.run(Listener())
    PredictScans(example.path, tmp_path / "out", floored.workspace, FAMILY, **HOW).run(Listener())
    with np.load(tmp_path / "out" / "scan.parts.npz") as labelled:
        assert set(np.unique(labelled["parts"])) <= {NOTHING, 0, 1}


def test_train_all_goes_the_whole_way_once(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.prepared, tmp_path / "workspace" / "prepared")
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, FAMILY, **HOW)
    steps = " ".join(stage.plan().steps)
    for step in ("gnn_fine", "gnn_coarse", "axis", "ranking", "label", "scan", "ancsh"):
        assert step in steps, "said before anything is done"
    dataset = open_dataset(stage.workspace, FAMILY)
    known = sum(map(len, dataset.labelled.values())) + len(dataset.hidden)
    assert f"scan {known + round(USED * len(dataset.unlabelled))} objects" in steps, "those to be labelled too"
    told = Listener()
    found = stage.run(told)
    assert [note for note in told.notes if note.startswith("to do")]
    # such networks find nothing that moves, so that there are no pseudo labels to learn from
    assert [note for note in told.notes if note.startswith(f"{CATEGORY}: no pseudo label")]
    assert {"gnn_fine", f"ancsh ({CATEGORY}, supervised, seed 0)"} <= found.data.keys()
    assert (stage.plan().steps, stage.plan().seconds) == ((), 0.0)
    before = contents(tmp_path / "workspace")
    stage.run(Listener())
    assert contents(tmp_path / "workspace") == before
    other = TrainAll(Workspace(tmp_path / "workspace", method="paper"), scanned.config, FAMILY, **HOW)
    assert [step for step in other.plan().steps if "by paper" in step]
    trained = other.run(Listener()).data
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
    stage = TrainAll(Workspace(tmp_path / "workspace"), scanned.config, **HOW)
    assert "ancsh" not in " ".join(stage.plan().steps)
    with pytest.raises(InputError, match="expected a labelled shape of safe to train on"):
        TrainAll(Workspace(tmp_path / "workspace"), scanned.config, "safe", **HOW).plan()


def test_a_users_scan_gives_parts_joints_and_a_picture(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=np.vstack([points, [[0.0, 0.0, -1.0]]]))
    told = Listener()
    found = PredictScans(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW).run(told)
    assert told.notes == [f"1 of {len(points) + 1} points are left out: they are not before the camera (z > 0)"]
    for part in found.data["parts"]:
        share = part["inliers"]
        agree = "not found" if share is None else f"{share:.0%} of them agree on where it is"
        assert f"part {part['id']}: {part['points']} points, {agree}\n" in found.text
    document = json.loads((tmp_path / "out" / "seen.json").read_text())
    assert document == found.data
    assert [joint["kind"] for joint in document["joints"]] == ["R"]
    assert sum(part["points"] for part in document["parts"]) == len(points), "of the scan's own points"
    assert (tmp_path / "out" / "seen.svg").read_text().startswith("<svg")
    with np.load(tmp_path / "out" / "seen.parts.npz") as labelled:
        np.testing.assert_array_equal(labelled["points"], points[labelled["places"]])
        said = [int((labelled["parts"] == part["id"]).sum()) for part in document["parts"]]
        assert sum(said) == len(points)
        assert said == [part["points"] for part in document["parts"]]


def test_every_scan_of_a_folder_is_looked_at_as_if_it_were_alone(scanned: Scanned, tmp_path: Path) -> None:
    seen = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points")
    scans = tmp_path / "scans"
    for name, points in (("first.npz", seen[0]), ("near/second.npz", seen[1]), ("near/second.npy", seen[0])):
        (scans / name).parent.mkdir(parents=True, exist_ok=True)
        np.save(scans / name, points) if name.endswith("npy") else np.savez(scans / name, points=points)
    (scans / "broken.ply").write_text("ply")
    (scans / "notes.txt").write_text("of the camera")
    np.save(scans / ".hidden.npy", seen[0])
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({10**12}, 3), }}".ljust(117) + "\n"
    (scans / "vast.npy").write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode())
    told = Listener()
    stage = PredictScans(scans, scans / "found", scanned.workspace, FAMILY, **HOW)
    assert "5 scans below" in stage.plan().steps[0]
    outcome = stage.run(told)
    names = [Path(document["scan"]).name for document in outcome.data["scans"]]
    assert names == ["first.npz", "second.npy", "second.npz"]
    assert outcome.failed == len(outcome.data["left_out"]) == 2
    assert {path.name for path in (scans / "found" / "near").iterdir()} == {
        f"second.{ending}.{what}" for ending in ("npy", "npz") for what in ("json", "svg", "parts.npz")
    }
    assert [line for line in outcome.data["left_out"] if "vast.npy: expected arrays of NumPy" in line]
    assert [line for line in outcome.data["left_out"] if "broken.ply: expected a PLY file" in line]
    assert [f"left out: {line}" for line in outcome.data["left_out"]] == told.notes
    assert outcome.text.splitlines()[0].startswith("first.npz: part 1 R, state ")
    assert outcome.text.splitlines()[1].startswith("near/second.npy: part 1 R")
    assert outcome.text.splitlines()[-1] == "3 scans, 2 left out"
    alone = PredictScans(scans / "near" / "second.npy", tmp_path / "alone", scanned.workspace, FAMILY, **HOW).run(Listener())
    assert alone.data == outcome.data["scans"][1]
    again = stage.run(Listener())
    assert again.data == outcome.data, "what was found in scans is none"
    arguments = [
        "--category",
        FAMILY,
        "--workspace",
        str(scanned.workspace.path),
        "--device",
        "cpu",
        "--out",
        str(tmp_path / "o"),
    ]
    result = CliRunner().invoke(app, ["predict", str(scans), *arguments, "--json"])
    assert result.exit_code == 1, result.output
    said = json.loads(result.stdout)
    assert (said["scans"], len(said["left_out"])) == (outcome.data["scans"], 2)
    around = PredictScans(scans, tmp_path, scanned.workspace, FAMILY, **HOW).run(Listener())
    assert around.data["scans"] == outcome.data["scans"], "into a folder that the scans are in"
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "near").write_text("a file")
    blocked = PredictScans(scans, tmp_path / "taken", scanned.workspace, FAMILY, **HOW).run(Listener())
    assert [Path(document["scan"]).name for document in blocked.data["scans"]] == ["first.npz"]
    assert [line for line in blocked.data["left_out"] if line.startswith("near/second.npy: ")]
    empty = PredictScans(tmp_path / "alone", tmp_path / "none", scanned.workspace, FAMILY, **HOW)
    with pytest.raises(InputError, match=r"expected a scan, one of \.npz"):
        empty.plan()


def test_a_finder_says_of_points_what_the_command_does(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    np.savez(tmp_path / "seen.npz", points=points)
    said = PredictScans(tmp_path / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW).run(Listener()).data
    finder = ScanFinder.load(scanned.workspace.root, FAMILY, device="cpu")
    found = finder.find(points)
    assert (finder.weights, finder.trained, finder.category) == (said["weights"], said["trained"], said["category"])
    assert [int((found.parts == part["id"]).sum()) for part in said["parts"]] == [part["points"] for part in said["parts"]]
    states = [np.nan if joint["state"] is None else joint["state"] for joint in said["joints"]]
    np.testing.assert_array_equal(found.estimate.states, states)
    for wrong in (points[:, :2], points[:0], np.full((40, 3), np.nan), -points, np.ones((40, 3))):
        with pytest.raises(ValueError, match=r"expected points \[n, 3\]"):
            finder.find(wrong)


def test_a_depth_image_in_millimetres_goes_through_the_command(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    depth = np.zeros((480, 640), np.uint16)
    columns, rows = np.round(points[:, :2] / points[:, 2:] * 500.0 + [320.0, 240.0]).astype(int).T
    depth[rows, columns] = np.round(1000.0 * points[:, 2])
    Image.fromarray(depth).save(tmp_path / "depth.png")
    camera = ["--intrinsics", "500,500,320,240", "--depth-scale", "1000"]
    where = ["--out", str(tmp_path / "out"), "--workspace", str(scanned.workspace.path), "--device", "cpu"]
    result = CliRunner().invoke(app, ["predict", str(tmp_path / "depth.png"), "--category", FAMILY, *camera, *where])
    assert result.exit_code == 0, result.output
    with np.load(tmp_path / "out" / "depth.parts.npz") as labelled:
        np.testing.assert_array_equal(labelled["places"], np.flatnonzero(depth))
        np.testing.assert_array_equal(np.round(1000.0 * labelled["points"][:, 2]), depth[depth > 0])
        assert np.abs(labelled["points"][:, None] - points[None]).max(axis=2).min(axis=1).max() < 0.01, "within a pixel"
    (joint,) = json.loads((tmp_path / "out" / "depth.json").read_text())["joints"]
    assert joint["kind"] == "R"


def test_an_example_is_the_test_scan_that_shows_all_parts_best(scanned: Scanned, tmp_path: Path) -> None:
    example = ExampleScan(scanned.workspace, FAMILY, tmp_path / "new" / "scan.npz", scanned.render())
    assert [step for step in example.plan().steps if "scan.npz" in step]
    name = example.run(Listener()).data["object"]
    test = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob(f"{name}-*.safetensors")))
    counts = [min(int((parts == part).sum()) for part in range(test.structure.part_count)) for parts in test.read("parts")]
    np.testing.assert_array_equal(read_scan(example.path).points, test.read("points", int(np.argmax(counts))))
    before = contents(tmp_path / "new")
    example.run(Listener())
    assert contents(tmp_path / "new") == before
    found = PredictScans(example.path, tmp_path / "out", scanned.workspace, FAMILY, **HOW).run(Listener())
    assert len(found.data["parts"]) == 2
    for taken in ("scan.npz", "points.npz", "scan.txt"):
        (tmp_path / taken).write_bytes(b"mine")
        np.savez(tmp_path / "points.npz", points=np.zeros((3, 3)))
        with pytest.raises(InputError, match=r"in the way|ends in \.npz"):
            ExampleScan(scanned.workspace, FAMILY, tmp_path / taken, scanned.render()).plan()
    assert (tmp_path / "scan.npz").read_bytes() == b"mine"


def test_an_example_is_scanned_only_where_there_are_no_scans(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    before = contents(workspace.path)
    command = ["render", "--category", FAMILY, "--workspace", str(workspace.path), "--workers", "1", "--example"]
    for other in (["--config", "small"], ["--seed", "1"]):  # by which all would be scanned anew
        result = CliRunner().invoke(app, [*command, str(tmp_path / "scan.npz"), *other])
        assert result.exit_code == 0, result.output
        assert contents(workspace.path) == before
    example = ExampleScan(workspace, FAMILY, tmp_path / "scan.npz", Render(workspace, scanned.config, FAMILY, beside=()))
    shutil.rmtree(workspace.scans / CATEGORY / "test")
    before = contents(workspace.path)
    with pytest.raises(InputError, match="expected scans of a test object"):
        example.run(Listener())
    assert contents(workspace.path) == before, "what was scanned stays"
    shutil.rmtree(workspace.scans)
    assert [step.split()[0] for step in example.plan().steps] == ["scan", "write"]
    assert example.run(Listener()).failed == 0
    assert [step.split()[0] for step in example.plan().steps] == ["write"]


def test_nothing_is_replaced_but_what_was_found_in_the_same_scan(scanned: Scanned, tmp_path: Path) -> None:
    points = open_scans(next((scanned.workspace.scans / CATEGORY / "test").glob("*.safetensors"))).read("points", 0)
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        np.savez(tmp_path / folder / "seen.npz", points=points)
    stages = [
        PredictScans(tmp_path / folder / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW) for folder in "ab"
    ]
    stages[0].run(Listener())
    stages[0].run(Listener())
    (tmp_path / "elsewhere").symlink_to(tmp_path / "a")
    PredictScans(tmp_path / "elsewhere" / "seen.npz", tmp_path / "out", scanned.workspace, FAMILY, **HOW).plan()
    before = contents(tmp_path / "out")
    for attempt in (stages[1].plan, lambda: stages[1].run(Listener())):
        with pytest.raises(InputError, match=r"seen\.json: is in the way"):
            attempt()
    assert contents(tmp_path / "out") == before
    (tmp_path / "out" / "seen.json").unlink()
    with pytest.raises(InputError, match=r"seen\.svg: is in the way"):
        stages[0].plan()


def test_what_is_no_scan_is_told_before_anything_runs(scanned: Scanned, tmp_path: Path) -> None:
    for name, problem in (("none.npz", "no such file"), (".", "expected a scan, one of")):
        with pytest.raises(InputError, match=problem):
            PredictScans(tmp_path / name, tmp_path / "out", scanned.workspace, FAMILY, **HOW).plan()


def test_a_category_without_networks_is_named_with_those_that_there_are(scanned: Scanned, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no networks that find a labtop in scans.*Laptop.*train all --category labtop"):
        PredictScans(tmp_path / "x.npz", tmp_path, scanned.workspace, "labtop").run(Listener())
    with pytest.raises(InputError, match="run kinmo render first"):
        TrainAncsh(Workspace(scanned.workspace.root), scanned.config, "safe").run(Listener())
