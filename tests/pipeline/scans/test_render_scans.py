"""Scanning of objects: roles, variants, skipped objects, and runs that are interrupted or repeated."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
from scanned_workspace import CATEGORY, FAMILY, Scanned, with_pseudo_labels
from trained_workspace import Recorder, contents

from kinmo.config import SensorConfig
from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.store import PreparedStore, write_index
from kinmo.pipeline.scans import render_scans
from kinmo.pipeline.scans.scan_dataset import COMPLETE, LABELLED, open_scan_dataset, scans_folder
from kinmo.scans.canonical.hinge_openings import hinge_opening
from kinmo.scans.files.scan_file import ROLES, ScanFile, count_objects, open_scans

SIZE, SMALLER = "size = 96", "size = 80"


def reasons(made: Scanned, role: str) -> dict[str, object]:
    """Results without scans in the folder of a role, by name."""
    cache = Cache(scans_folder(made.workspace, CATEGORY, role))
    return {name: cache.data(name) for name in cache if cache.data(name)}


def test_every_object_has_one_role_and_its_frames(scanned: Scanned) -> None:
    dataset = open_scan_dataset(scanned.workspace, CATEGORY.lower())
    assert dataset.category == CATEGORY
    assert str(dataset.structure) == "2 parts (R on 0)"
    for role, frames in (("train", 4), ("oracle", 4), ("unlabelled", 2), ("validation", 2), ("test", 2)):
        assert dataset.files[role], role
        counts = Counter[str]()
        for file in dataset.files[role]:
            counts[file.id] += file.frames + sum(file.skipped.values())
        assert set(counts.values()) == {frames}, role
    labelled = {file.id for role in LABELLED for file in dataset.files[role]}
    assert not labelled & {file.id for file in dataset.files["oracle"]}
    assert {file.id for file in dataset.files["oracle"]} == {file.id for file in dataset.files["unlabelled"]}


def test_training_objects_are_scanned_in_variants_and_count_once(scanned: Scanned) -> None:
    dataset = open_scan_dataset(scanned.workspace, CATEGORY)
    for role, count in (("train", 2), ("oracle", 2), ("unlabelled", 1), ("validation", 1), ("test", 1)):
        by_object: dict[str, list[ScanFile]] = {}
        for file in dataset.files[role]:
            by_object.setdefault(file.id, []).append(file)
        assert {len(files) for files in by_object.values()} == {count}, role
        assert count_objects(dataset.files[role]) == len(by_object)
        if count == 2:
            assert all(not np.allclose(one.extents.sizes, other.extents.sizes) for one, other in by_object.values())
    report = scanned.render(extra=ROLES).run(Recorder()).data["categories"][CATEGORY]
    found = {role: count_objects(dataset.files[role]) for role in (*LABELLED, "oracle")}
    assert {role: report["objects"][role] for role in found} == found


def test_training_objects_that_become_validation_objects_have_no_variants(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    made.remove_scans("validation")
    before = open_scan_dataset(scanned.workspace, CATEGORY)
    dataset = open_scan_dataset(made.workspace, CATEGORY)
    (chosen,) = dataset.files["validation"]
    assert not chosen.provenance.variant
    assert {file.id for file in dataset.files["train"]} == {file.id for file in before.files["train"]} - {chosen.id}
    assert any(file.provenance.variant for file in dataset.files["train"])


def test_as_in_the_release_hinges_turn_in_lockstep_and_objects_have_no_variants(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path).changed(tmp_path, "[scans]\nstates = 2\n", "[scans]\nrelease = true\nstates = 5\n")
    made.render().run(Recorder())
    files = open_scan_dataset(made.workspace, CATEGORY).files
    assert not any(file.provenance.variant for role in ROLES for file in files[role])
    for file in files["train"]:
        degrees = np.degrees(np.unique(file.read("values")[:, 0].round(6)))
        np.testing.assert_allclose(degrees - degrees[0], [0.0, 30.0, 60.0, 90.0, 120.0], atol=1e-3)


def test_scans_that_are_up_to_date_are_not_made_again(scanned: Scanned) -> None:
    before, observer = contents(scanned.workspace.path), Recorder()
    plan = scanned.render(extra=ROLES).plan()
    assert (plan.steps, plan.seconds) == ((), 0.0)
    scanned.render(extra=ROLES).run(observer)
    assert observer.notes == ["already scanned"]
    assert contents(scanned.workspace.path) == before


def test_scans_depend_on_their_own_sensor_alone(scanned: Scanned, tmp_path: Path) -> None:
    other = scanned.changed(tmp_path, "[scans]", "[scans.noisy_sensor]\nnoise = 0.5\n[scans]")
    assert other.render(extra=ROLES).plan().steps == ()
    assert scanned.render(extra=ROLES, sensor=SensorConfig()).plan().steps == ()
    (step,) = scanned.render(extra=ROLES, sensor=SensorConfig(noise=0.5)).plan().steps
    count = sum(count_objects(files) for files in open_scan_dataset(scanned.workspace, CATEGORY).files.values())
    assert step.startswith(f"scan {count} objects (Pliers)")


def test_a_method_without_pseudo_labels_leaves_nothing_to_scan(scanned: Scanned) -> None:
    assert scanned.render(method="paper").plan().steps == ()


def test_only_the_roles_that_are_asked_for_are_scanned_beside_labelled_objects(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    for role in ROLES:
        made.remove_scans(role)
    for extra in ((), ("oracle",), ("unlabelled",)):
        found = made.render(extra=extra).run(Recorder())
        assert set(found.data["categories"][CATEGORY]["objects"]) == {*LABELLED, *extra}
    assert open_scan_dataset(made.workspace, CATEGORY).files["oracle"], "scans of roles that are not asked for stay"


def test_a_role_whose_outdated_scans_are_removed_is_no_longer_complete(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    assert open_scan_dataset(made.workspace, CATEGORY).files["unlabelled"]
    made.render(seed=1).run(Recorder())
    assert not list(made.scans("unlabelled"))
    assert COMPLETE not in Cache(scans_folder(made.workspace, CATEGORY, "unlabelled"))
    assert COMPLETE in Cache(scans_folder(made.workspace, CATEGORY, "train"))


def test_an_object_that_cannot_be_scanned_has_a_reason_and_is_not_tried_again(scanned: Scanned, tmp_path: Path) -> None:
    made, observer = scanned.copied(tmp_path).changed(tmp_path, "[scans]", "[scans]\nsmallest_part = 1.0"), Recorder()
    found = made.render().run(observer)
    assert found.failed and observer.notes == [f"{CATEGORY}: no frame of a training object"]
    skipped = {role: list(by_id.values()) for role, by_id in found.data["skipped"].items()}
    assert {"train", "oracle"} <= set(skipped), "in every role"
    assert all("no part of it moves that is large enough" in reason for own in skipped.values() for reason in own)
    assert found.text.count("skipped: ") == sum(map(len, skipped.values()))
    assert not list(made.scans("train"))
    assert reasons(made, "train")
    assert made.render().plan().steps == ()


def test_frames_that_show_too_little_are_counted_with_the_reason(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path).changed(tmp_path, "least_pixels = 1\n", "least_pixels = 100000\n")
    found = made.render(extra=()).run(Recorder())
    skipped = found.data["categories"][CATEGORY]["skipped frames"]
    assert sum(skipped.values()) > 0
    for reason, count in skipped.items():
        assert f"{count} {reason}" in found.text and "fewer than 100000 pixels" in reason


def test_an_object_that_cannot_be_read_now_is_scanned_once_it_can(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    made.remove_scans("oracle")
    (entry, *_) = open_dataset(made.workspace, FAMILY).oracle
    source, away = Path(entry.source), tmp_path / "away"
    source.rename(away)
    try:
        found = made.render().run(Recorder())
        assert made.render().plan().steps == (), "nothing waits for a shape that is gone"
    finally:
        away.rename(source)
    assert found.failed == 1
    assert list(found.data["skipped"]["oracle"]) == [entry.id] and "result.json: missing" in found.text
    assert not reasons(made, "oracle")
    assert len(made.render().plan().steps) == 1
    assert made.render().run(Recorder()).failed == 0
    assert entry.id in {file.id for file in open_scan_dataset(made.workspace, CATEGORY).files["oracle"]}


def test_scans_of_an_interrupted_run_are_not_used_until_it_is_finished(
    scanned: Scanned, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = scanned.copied(tmp_path)
    next(made.scans("test")).unlink()

    def interrupted(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(render_scans, "runner_for", interrupted)
        with pytest.raises(KeyboardInterrupt):
            made.render().run(Recorder())
    for ask in (made.train().plan, lambda: open_scan_dataset(made.workspace, CATEGORY)):
        with pytest.raises(InputError, match="scanning was interrupted: run kinmo render again"):
            ask()
    made.render().run(Recorder())
    assert made.train().plan().steps == ()
    made.interrupt("train")  # after all scans were made
    assert made.render().plan().steps == (f"check the scans of {CATEGORY}, which were interrupted",)
    made.render().run(Recorder())
    assert made.render().plan().steps == ()
    assert open_scan_dataset(made.workspace, CATEGORY).files["test"]


def test_only_the_interrupted_command_completes_its_scans(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    next(made.scans("unlabelled")).unlink()
    made.interrupt("unlabelled")
    assert made.render().plan().steps == ()
    made.render().run(Recorder())
    assert not open_scan_dataset(made.workspace, CATEGORY).files["unlabelled"]
    made.render(extra=("unlabelled",)).run(Recorder())
    assert open_scan_dataset(made.workspace, CATEGORY).files["unlabelled"]


def test_scans_of_objects_that_are_gone_are_removed(scanned: Scanned, tmp_path: Path) -> None:
    made = scanned.copied(tmp_path)
    folders = [scans_folder(made.workspace, CATEGORY, role) for role in ("train", "pseudo")]
    gone = [folder / "gone-partnet_mobility.safetensors" for folder in folders]
    for path in gone:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(next(folders[0].glob("*.safetensors")).read_bytes())
        Cache(path.parent).store(path.stem, "old key", [path])
    made.render().run(Recorder())
    assert not any(path.exists() for path in gone), "in a role without objects too"
    assert not any(path.stem in Cache(path.parent) for path in gone)


def test_scans_stay_until_new_ones_replace_them(scanned: Scanned, tmp_path: Path) -> None:
    class Interrupting(Recorder):
        def progress(self, *_: object) -> None:
            raise KeyboardInterrupt

    made = scanned.copied(tmp_path)
    before = contents(made.workspace.scans)
    with pytest.raises(KeyboardInterrupt):
        made.changed(tmp_path, SIZE, SMALLER).render(workers=1).run(Interrupting())
    left = contents(made.workspace.scans)
    assert left.keys() == before.keys()
    assert all(COMPLETE not in Cache(scans_folder(made.workspace, CATEGORY, role)) for role in (*LABELLED, "oracle"))
    changed = {path for path in before if left[path] != before[path]}
    assert len({open_scans(made.workspace.scans / path).object for path in changed}) == 1
    made.render(workers=1).run(Recorder())
    assert contents(made.workspace.scans) == before


def test_an_object_that_cannot_be_scanned_again_keeps_no_outdated_scans(scanned: Scanned, tmp_path: Path) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    made.render().run(Recorder())
    assert open_scan_dataset(made.workspace, CATEGORY).files["pseudo"]
    entry = open_dataset(made.workspace, FAMILY).labelled[Split.TRAIN][0]
    source, away = Path(entry.source), tmp_path / "away"
    source.rename(away)
    try:
        assert made.changed(tmp_path, SIZE, SMALLER).render().run(Recorder()).failed == 2
    finally:
        away.rename(source)
    files = open_scan_dataset(made.workspace, CATEGORY).files
    assert files["train"] and entry.id not in {file.id for file in files["train"]}
    assert not files["pseudo"], "they wait for the openings of its hinges"


def test_scans_by_a_pseudo_label_change_with_the_label_and_the_shape(scanned: Scanned, tmp_path: Path) -> None:
    made, (label, *_) = with_pseudo_labels(scanned, tmp_path)
    stage = made.render()
    assert len(stage.plan().steps) == 1
    stage.run(Recorder())
    assert stage.plan().steps == ()
    (entry, *_) = open_dataset(made.workspace, FAMILY).unlabelled
    scanned_ids = {file.id for file in open_scan_dataset(made.workspace, CATEGORY).files["pseudo"]}
    assert entry.id in scanned_ids, "whatever the name of its folder"
    text = label.read_text(encoding="utf-8")
    label.write_text(text, encoding="utf-8")
    assert stage.plan().steps == (), "the contents are the same"
    label.write_text(text + " ", encoding="utf-8")
    assert len(stage.plan().steps) == 1
    stage.run(Recorder())
    entries = PreparedStore(made.workspace.prepared).entries
    write_index(made.workspace.prepared, [replace(other, key="new") if other == entry else other for other in entries])
    assert len(stage.plan().steps) == 1


def test_scans_by_pseudo_labels_wait_for_labelled_objects_that_show_hinge_openings(scanned: Scanned, tmp_path: Path) -> None:
    made, _ = with_pseudo_labels(scanned, tmp_path)
    stage = made.render()
    entry = open_dataset(made.workspace, FAMILY).labelled[Split.TRAIN][0]
    for path in made.scans("train"):
        if path.name.startswith(f"{entry.id}-"):
            path.unlink()
    source, away = Path(entry.source), tmp_path / "away"
    source.rename(away)
    try:
        found = stage.run(Recorder())
    finally:
        away.rename(source)
    assert found.failed == 2
    count = len(open_dataset(made.workspace, FAMILY).unlabelled)
    missing = f"{entry.id}-partnet_mobility"
    assert f"{count} objects with pseudo labels: skipped because scans of {missing} are missing" in found.text
    assert not open_scan_dataset(made.workspace, CATEGORY).files["pseudo"]
    assert stage.run(Recorder()).failed == 0
    assert open_scan_dataset(made.workspace, CATEGORY).files["pseudo"]
    assert stage.plan().steps == ()


def test_hinges_without_known_limits_open_as_far_as_labelled_ones(scanned: Scanned, tmp_path: Path) -> None:
    made, labels = with_pseudo_labels(scanned, tmp_path)
    for label in labels:
        bodies = json.loads(label.read_text(encoding="utf-8"))
        for body in bodies:
            if body["joint"] == "hinge":
                body["jointData"]["limit"] |= {"a": -90.0, "b": 90.0, "noLimit": False}
        label.write_text(json.dumps(bodies), encoding="utf-8")
    made.render().run(Recorder())
    files = open_scan_dataset(made.workspace, CATEGORY).files
    usual = [hinge_opening(file.joints[0]) for file in files["train"]]
    assert files["pseudo"] and None not in usual
    for file in files["pseudo"]:
        assert hinge_opening(file.joints[0]) in [pytest.approx(known) for known in usual]
