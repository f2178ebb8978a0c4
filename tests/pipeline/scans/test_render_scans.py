"""What is scanned, in which role, and what is left out."""

from __future__ import annotations

import json
import math
import shutil
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from kinmo.pipeline.scans.refusal import REFUSED
from scan_road import CATEGORY, FAMILY, Scanned, pseudo_labelled, smaller
from trained_workspace import Recorder, contents

from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import read_header
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans import render_scans as render
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_dataset import LABELLED, open_scan_dataset, scans_of, unfinished
from kinmo.scans.canonical.hinge_openings import hinge_opening
from kinmo.scans.files.scan_file import ROLES, ScanFile, count_objects, open_scans


def test_every_object_has_one_role_and_its_frames(scanned: Scanned) -> None:
    dataset = open_scan_dataset(scanned.workspace, CATEGORY.lower())
    assert dataset.category == CATEGORY
    assert str(dataset.structure) == "2 parts (R on 0)"
    for role, frames in (("train", 4), ("hidden", 4), ("unlabelled", 2), ("validation", 2), ("test", 2)):
        assert dataset.files[role], role
        drawn = Counter[str]()
        for file in dataset.files[role]:
            drawn[file.id] += file.frames + sum(file.skipped.values())
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
    report = scanned.render(beside=ROLES).run(Recorder()).data["categories"][CATEGORY]
    found = {role: count_objects(dataset.files[role]) for role in ("train", "hidden", "validation", "test")}
    assert {role: report["objects"][role] for role in found} == found


def test_objects_that_stand_in_for_validation_ones_are_seen_as_they_are(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    shutil.rmtree(tmp_path / "workspace" / "scans" / CATEGORY / "validation")
    before = open_scan_dataset(scanned.workspace, CATEGORY)
    dataset = open_scan_dataset(Workspace(tmp_path / "workspace"), CATEGORY)
    (chosen,) = dataset.files["validation"]
    assert not chosen.provenance.variant
    assert {file.id for file in dataset.files["train"]} == {file.id for file in before.files["train"]} - {chosen.id}
    assert any(file.provenance.variant for file in dataset.files["train"])


def test_in_lockstep_an_object_and_those_like_it_go_through_all_steps_together(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), tmp_path / "file.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("states = 2\n", 'states = 5\nsampling = "lockstep"\n', 1)
    config.write_text(text.replace("[scans]", "[scans]\nvariants = 2"), encoding="utf-8")
    Render(workspace, str(config), FAMILY, beside=()).run(Recorder())
    opened: dict[str, set[float]] = {}
    for path in scans_of(workspace, CATEGORY, "train").glob("*.safetensors"):
        file = open_scans(path)
        (joint,) = file.joints
        assert joint.lower is not None and joint.upper is not None
        shares = (file.read("values")[:, 0] - joint.lower) / (joint.upper - joint.lower)
        opened.setdefault(file.id, set()).update(shares.round(6).tolist())
    assert set.union(*opened.values()) == {0.0, 0.25, 0.5, 0.75, 1.0}


def test_objects_that_are_not_closed_have_no_variants(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace, config = Workspace(tmp_path / "workspace"), tmp_path / "file.toml"
    text = Path(scanned.config).read_text(encoding="utf-8").replace("[scans]", '[scans]\ncanonical = "file"')
    config.write_text(text, encoding="utf-8")
    Render(workspace, str(config), FAMILY).run(Recorder())
    files = open_scan_dataset(workspace, CATEGORY).files
    assert not any(file.provenance.variant for role in ROLES for file in files[role])


def test_what_was_scanned_is_not_scanned_again(scanned: Scanned) -> None:
    before, told = contents(scanned.workspace.path), Recorder()
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
        found = Render(workspace, scanned.config, FAMILY, beside=beside).run(Recorder())
        assert set(found.data["categories"][CATEGORY]["objects"]) == roles
    assert open_scan_dataset(workspace, CATEGORY).files["hidden"], "what is not asked for stays"


def test_an_object_that_cannot_be_scanned_says_why_and_is_not_tried_again(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    config = tmp_path / "strict.toml"
    config.write_text(Path(scanned.config).read_text(encoding="utf-8") + "smallest_part = 1.0\n", encoding="utf-8")
    stage = Render(Workspace(tmp_path / "workspace"), str(config), FAMILY)
    told = Recorder()
    found = stage.run(told)
    assert found.failed and told.notes == [f"{CATEGORY}: no frame of an object to train on"]
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
    found = Render(Workspace(tmp_path / "workspace"), str(config), FAMILY, beside=()).run(Recorder())
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
        found = stage.run(Recorder())
        assert stage.plan().steps == (), "nothing waits for what has gone"
    finally:
        away.rename(source)
    assert found.failed == 1
    assert list(found.data["refused"]["hidden"]) == [entry.id] and "result.json: missing" in found.text
    assert not list(workspace.scans.rglob(f"*{REFUSED}"))
    assert len(stage.plan().steps) == 1
    assert stage.run(Recorder()).failed == 0
    assert entry.id in {file.id for file in open_scan_dataset(workspace, CATEGORY).files["hidden"]}


def test_scans_whose_making_was_stopped_are_not_used_until_it_is_done(
    scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    made = Scanned(Workspace(tmp_path / "workspace"), scanned.config)
    next((made.workspace.scans / CATEGORY / "test").glob("*.safetensors")).unlink()

    def stopped(*_: object) -> Iterator[object]:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(render, "map_unordered", stopped)
        with pytest.raises(KeyboardInterrupt):
            made.render().run(Recorder())
    for ask in (made.train("supervised").plan, lambda: open_scan_dataset(made.workspace, CATEGORY)):
        with pytest.raises(InputError, match="scanning was stopped before all was done: run kinmo render again"):
            ask()
    made.render().run(Recorder())
    assert made.train("supervised").plan().steps == ()
    unfinished(made.workspace, CATEGORY, "train").touch()  # stopped when all was done but to say so
    assert made.render().plan().steps
    made.render().run(Recorder())
    assert made.render().plan().steps == ()
    assert open_scan_dataset(made.workspace, CATEGORY).files["test"]


def test_only_the_command_that_was_stopped_ends_what_it_began(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    made = Scanned(Workspace(tmp_path / "workspace"), scanned.config)
    folder = scans_of(made.workspace, CATEGORY, "unlabelled")
    next(folder.glob("*.safetensors")).unlink()
    unfinished(made.workspace, CATEGORY, "unlabelled").touch()
    shutil.rmtree(made.workspace.models)
    assert made.render().plan().steps == ()
    made.render().run(Recorder())
    assert not open_scan_dataset(made.workspace, CATEGORY).files["unlabelled"]
    for begin in (made.train("semi").plan, lambda: made.train("semi").run(Recorder())):
        with pytest.raises(InputError, match="no scans of unlabelled objects of Laptop: run kinmo render --unlabelled"):
            begin()
    assert not made.workspace.models.exists(), "told before the networks that are to label are trained"
    made.render(beside=("unlabelled",)).run(Recorder())
    assert open_scan_dataset(made.workspace, CATEGORY).files["unlabelled"]


def test_scans_of_objects_that_have_gone_go_too(scanned: Scanned, tmp_path: Path) -> None:
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    folders = [scans_of(workspace, CATEGORY, role) for role in ("train", "pseudo")]
    strays = [folder / "gone-partnet_mobility.safetensors" for folder in folders]
    for stray in strays:
        stray.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(next(folders[0].glob("*.safetensors")), stray)
    Render(workspace, scanned.config, FAMILY).run(Recorder())
    assert not any(stray.exists() for stray in strays), "also in a role that no object has any more"


def test_scans_stay_until_others_take_their_place(scanned: Scanned, tmp_path: Path) -> None:
    class CutOff(Recorder):
        def progress(self, *_: object) -> None:
            raise KeyboardInterrupt

    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    workspace = Workspace(tmp_path / "workspace")
    before = contents(workspace.scans)
    with pytest.raises(KeyboardInterrupt):
        Render(workspace, smaller(scanned, tmp_path), FAMILY, workers=1).run(CutOff())
    left = contents(workspace.scans)
    marks = {str(unfinished(workspace, CATEGORY, role).relative_to(workspace.scans)) for role in (*LABELLED, "hidden")}
    assert left.keys() - before.keys() == marks
    assert before.keys() <= left.keys()
    changed = {path for path in before if left[path] != before[path]}
    assert len({open_scans(workspace.scans / path).object for path in changed}) == 1
    Render(workspace, scanned.config, FAMILY, workers=1).run(Recorder())
    assert contents(workspace.scans) == before


def test_an_object_that_cannot_be_scanned_anew_keeps_no_scans_of_another_way(scanned: Scanned, tmp_path: Path) -> None:
    workspace, _ = pseudo_labelled(scanned, tmp_path / "workspace")
    Render(workspace, scanned.config, FAMILY).run(Recorder())
    assert open_scan_dataset(workspace, CATEGORY).files["pseudo"]
    entry = open_dataset(workspace, FAMILY).labelled[Split.TRAIN][0]
    source, away = Path(entry.source), tmp_path / "away"
    source.rename(away)
    try:
        assert Render(workspace, smaller(scanned, tmp_path), FAMILY).run(Recorder()).failed == 2
    finally:
        away.rename(source)
    files = open_scan_dataset(workspace, CATEGORY).files
    assert files["train"] and entry.id not in {file.id for file in files["train"]}
    assert not files["pseudo"], "they wait for what it shows"


def test_scans_by_a_pseudo_label_are_made_anew_when_the_label_or_the_shape_changes(scanned: Scanned, tmp_path: Path) -> None:
    workspace, (label, *_) = pseudo_labelled(scanned, tmp_path / "workspace")
    stage = Render(workspace, scanned.config, FAMILY)
    assert len(stage.plan().steps) == 1
    stage.run(Recorder())
    assert stage.plan().steps == ()
    (entry, *_) = open_dataset(workspace, FAMILY).unlabelled
    scanned_ids = {file.id for file in open_scan_dataset(workspace, CATEGORY).files["pseudo"]}
    assert entry.id in scanned_ids, "whatever its folder is called"
    label.write_text(label.read_text(encoding="utf-8") + " ", encoding="utf-8")
    assert len(stage.plan().steps) == 1
    stage.run(Recorder())
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
        found = stage.run(Recorder())
    finally:
        away.rename(source)
    assert found.failed == 2
    count = len(open_dataset(workspace, FAMILY).unlabelled)
    assert f"{count} objects with pseudo labels: without scans of {entry.id}-partnet_mobility" in found.text
    assert not open_scan_dataset(workspace, CATEGORY).files["pseudo"]
    assert stage.run(Recorder()).failed == 0
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
    Render(workspace, scanned.config, FAMILY).run(Recorder())
    files = open_scan_dataset(workspace, CATEGORY).files
    usual = [max(hinge_opening(file.joints[0]) or 0.0, math.pi / 2) for file in files["train"]]
    assert files["pseudo"]
    for file in files["pseudo"]:
        assert hinge_opening(file.joints[0]) in [pytest.approx(known) for known in usual]
