"""Objects with another structure than most training objects are not scanned, because no network is trained for them."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path

import pytest
from scanned_workspace import Scanned, prepared_in
from trained_workspace import Recorder, contents

from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.render_summary import MAX_LINES
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset, scans_folder
from kinmo.scans.files.scan_file import Role, ScanFile, count_objects, open_scans

FAMILY, CATEGORY = "refrigerator", "Refrigerator"
OTHERS: tuple[Role, ...] = ("validation", "test", "oracle")
"""Roles of objects that are scanned only if they have the structure of most training objects."""


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> RenderScans:
    """Finished rendering of refrigerators with all numbers of doors and drawers."""
    made: Scanned = prepared_in(tmp_path_factory.mktemp("mixed"), FAMILY, 12)
    stage = RenderScans(made.workspace, made.config, FAMILY)
    stage.run(Recorder())
    return stage


def dataset_of(stage: RenderScans) -> ScanDataset:
    return open_scan_dataset(stage.workspace, CATEGORY)


def scans_of(stage: RenderScans, role: Role) -> list[ScanFile]:
    return [open_scans(path) for path in scans_folder(stage.workspace, CATEGORY, role).glob("*.safetensors")]


def skipped_structures(stage: RenderScans, role: Role) -> set[str]:
    """Structures for which objects were not scanned."""
    cache = Cache(scans_folder(stage.workspace, CATEGORY, role))
    return {data["structure"] for name in cache if (data := cache.data(name)) and data["structure"]}


def copied(stage: RenderScans, folder: Path, config: str | None = None) -> RenderScans:
    """The same in a copy of the workspace, with another configuration if there is one."""
    shutil.copytree(stage.workspace.path, folder / "workspace")
    return RenderScans(Workspace(folder / "workspace"), config or stage.config, FAMILY)


def test_only_training_objects_are_scanned_whatever_their_structure(mixed: RenderScans) -> None:
    assert len({file.structure for file in scans_of(mixed, "train")}) > 1
    assert {file.structure for role in OTHERS for file in scans_of(mixed, role)} == {dataset_of(mixed).structure}
    assert mixed.plan().steps == ()


def test_objects_that_are_not_scanned_are_counted_by_structure(mixed: RenderScans) -> None:
    dataset, known = dataset_of(mixed), open_dataset(mixed.workspace, CATEGORY)
    entries = {"validation": known.labelled[Split.VALIDATION], "test": known.labelled[Split.TEST], "oracle": known.oracle}
    for role in OTHERS:
        skipped = sum(count for (_, other, _), count in dataset.others.items() if other == role)
        assert count_objects(dataset.files[role]) + skipped == len(entries[role]), role
    outcome = mixed.run(Recorder())
    not_scanned = outcome.data["categories"][CATEGORY]["not scanned"]
    by_structure = Counter[str]()
    for (structure, role, _), count in dataset.others.items():
        by_structure[structure] += count * (role in OTHERS)
    assert not_scanned and not_scanned == {name: count for name, count in by_structure.items() if name in not_scanned}
    assert str(dataset.structure) not in not_scanned
    (first, count), *_ = not_scanned.items()
    assert f"{count} {first}, not scanned\n" in outcome.text
    rare = list(not_scanned.values())[MAX_LINES:]
    assert not rare or f"{sum(rare)} of {len(rare)} more structures, not scanned" in outcome.text
    assert not outcome.data["skipped"]


def test_objects_are_scanned_once_their_structure_has_become_the_usual_one(
    mixed: RenderScans, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stage = copied(mixed, tmp_path)
    skipped_before = skipped_structures(stage, "oracle")
    other = next(file.structure for file in scans_of(stage, "train") if str(file.structure) in skipped_before)
    assert other not in {file.structure for file in dataset_of(mixed).files["train"]}
    monkeypatch.setattr("kinmo.pipeline.scans.render_jobs.usual_structure", lambda _: other)
    assert stage.plan().steps
    stage.run(Recorder())
    assert other in {file.structure for file in scans_of(stage, "oracle")}
    assert str(other) not in skipped_structures(stage, "oracle")


@pytest.mark.parametrize("stored", [0, 1, 3])
def test_an_interrupted_run_ends_like_an_undisturbed_one(
    mixed: RenderScans, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stored: int
) -> None:
    stage, left = copied(mixed, tmp_path), [stored]
    shutil.rmtree(stage.workspace.scans)
    store = Cache.store

    def interrupt(cache: Cache, name: str, key: str, *rest: object, **data: object) -> None:
        if data:  # the reason why an object is not scanned
            left[0] -= 1
            if left[0] < 0:
                raise KeyboardInterrupt
        store(cache, name, key, *rest, **data)  # type: ignore[arg-type]

    with monkeypatch.context() as patched:
        patched.setattr(Cache, "store", interrupt)
        with pytest.raises(KeyboardInterrupt):
            stage.run(Recorder())
    stage.run(Recorder())
    assert contents(stage.workspace.scans) == contents(mixed.workspace.scans)
    assert all(skipped_structures(stage, role) == skipped_structures(mixed, role) for role in OTHERS)
    assert stage.plan().steps == ()


def with_joints(stage: RenderScans, folder: Path, joints: str) -> RenderScans:
    """The same in a copy of the workspace, for objects with some joints."""
    config = folder / "joints.toml"
    config.write_text(Path(stage.config).read_text(encoding="utf-8").replace("[scans]", f"[scans]\njoints = {joints}"), "utf-8")
    return copied(stage, folder, str(config))


def test_only_objects_with_the_joints_that_the_configuration_names_are_scanned(mixed: RenderScans, tmp_path: Path) -> None:
    usual = dataset_of(mixed).structure
    rare = next(file.structure for file in scans_of(mixed, "train") if file.structure != usual)
    named = [f"{kind.value} on {parent}" for kind, parent in zip(rare.kinds, rare.parents, strict=True)]
    stage = with_joints(mixed, tmp_path, str(named))
    outcome = stage.run(Recorder())
    assert stage.plan().steps == ()
    dataset = dataset_of(stage)
    assert dataset.structure == rare
    assert set(outcome.data["categories"][CATEGORY]["structures"]) == {str(rare)}
    assert outcome.data["categories"][CATEGORY]["not scanned"][str(usual)] > 1
    assert dataset.others[str(usual), "train", "partnet_mobility"] >= 1


def test_joints_that_no_labelled_object_has_are_reported_with_those_that_there_are(mixed: RenderScans, tmp_path: Path) -> None:
    stage = with_joints(mixed, tmp_path, '["PR on 0", "PR on 1"]')
    outcome = stage.run(Recorder())
    assert not outcome.data["categories"][CATEGORY]["objects"]
    with pytest.raises(
        InputError, match=r"labelled shape to train on; the shapes have .* not the joints of scans\.joints"
    ) as error:
        dataset_of(stage)
    assert str(dataset_of(mixed).structure) in str(error.value)


@pytest.mark.parametrize("joints", ['["R"]', '["R on 1"]', '["revolute on 0"]', '["R on 0", "P on 2"]'])
def test_joints_in_another_form_are_an_error(mixed: RenderScans, tmp_path: Path, joints: str) -> None:
    with pytest.raises(InputError, match=r"scans\.joints: expected R, P, PR on a part before part \d, such as R on 0"):
        with_joints(mixed, tmp_path, joints).run(Recorder())
