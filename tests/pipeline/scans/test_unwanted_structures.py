"""Objects that no network is trained for, as they have another structure than most of those to train on, are not scanned."""

from __future__ import annotations

import shutil
from collections import Counter
from pathlib import Path

import pytest
from kinmo.scans.object_structure import Structure
from scan_road import prepared_in
from trained_workspace import Recorder, contents

from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.workspace import Workspace
from kinmo.pipeline.scans import render_jobs as jobs
from kinmo.pipeline.scans.refusal import REFUSED, Refusal, read_refusal
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.render_summary import LINES
from kinmo.pipeline.scans.scan_dataset import ScanDataset, open_scan_dataset, scans_of
from kinmo.scans.files.scan_file import Role, count_objects, open_scans

FAMILY, CATEGORY = "refrigerator", "Refrigerator"
CHOSEN: tuple[Role, ...] = ("validation", "test", "hidden")


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> Render:
    """Rendering of refrigerators with doors and drawers of all numbers, done once."""
    made = prepared_in(tmp_path_factory.mktemp("mixed"), FAMILY, 12)
    stage = Render(made.workspace, made.config, FAMILY)
    stage.run(Recorder())
    return stage


def dataset_of(stage: Render) -> ScanDataset:
    return open_scan_dataset(stage.workspace, CATEGORY)


def refused_structures(folder: Path) -> set[str | None]:
    """Those for which objects there were not scanned."""
    refusals = (read_refusal(path) for path in folder.glob(f"*{REFUSED}"))
    return {refusal.structure for refusal in refusals if refusal is not None}


def anew(stage: Render, folder: Path) -> Render:
    """The same in a copy of the workspace without scans."""
    shutil.copytree(stage.workspace.path, folder / "workspace")
    workspace = Workspace(folder / "workspace")
    shutil.rmtree(workspace.scans)
    return Render(workspace, stage.config, FAMILY)


def test_only_objects_to_train_on_are_scanned_whatever_their_structure(mixed: Render) -> None:
    structure = dataset_of(mixed).structure

    def scanned(role: Role) -> set[Structure]:
        return {open_scans(path).structure for path in scans_of(mixed.workspace, CATEGORY, role).glob("*.safetensors")}

    assert len(scanned("train")) > 1
    assert set.union(*map(scanned, CHOSEN)) == {structure}
    assert mixed.plan().steps == ()


def test_those_that_are_not_are_counted_with_their_structures(mixed: Render) -> None:
    dataset, known = dataset_of(mixed), open_dataset(mixed.workspace, CATEGORY)
    entries = {"validation": known.labelled[Split.VALIDATION], "test": known.labelled[Split.TEST], "hidden": known.hidden}
    for role in CHOSEN:
        left_out = sum(count for (_, other, _), count in dataset.others.items() if other == role)
        assert count_objects(dataset.files[role]) + left_out == len(entries[role]), role
    told = mixed.run(Recorder())
    not_scanned = told.data["categories"][CATEGORY]["not scanned"]
    by_structure = Counter[str]()
    for (structure, role, _), count in dataset.others.items():
        by_structure[structure] += count * (role in CHOSEN)
    assert not_scanned and not_scanned == {name: count for name, count in by_structure.items() if name in not_scanned}
    assert str(dataset.structure) not in not_scanned
    (first, count), *_ = not_scanned.items()
    assert f"{count} {first}, not scanned\n" in told.text
    rare = list(not_scanned.values())[LINES:]
    assert not rare or f"{sum(rare)} of {len(rare)} more structures, not scanned" in told.text
    assert not told.data["refused"]


def test_what_has_become_the_structure_of_most_is_scanned(
    mixed: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(mixed.workspace.path, tmp_path / "workspace")
    stage = Render(Workspace(tmp_path / "workspace"), mixed.config, FAMILY)
    hidden = scans_of(stage.workspace, CATEGORY, "hidden")
    refused_before = refused_structures(hidden)
    of_train = {file.structure for file in dataset_of(mixed).files["train"]}
    train = [open_scans(path) for path in scans_of(stage.workspace, CATEGORY, "train").glob("*.safetensors")]
    other = next(file.structure for file in train if str(file.structure) in refused_before)
    assert other not in of_train
    monkeypatch.setattr("kinmo.pipeline.scans.render_scans.usual_structure", lambda _: other)
    assert stage.plan().steps
    stage.run(Recorder())
    assert other in {open_scans(path).structure for path in hidden.glob("*.safetensors")}
    assert str(other) not in refused_structures(hidden)


@pytest.mark.parametrize("refusals", [0, 1, 3])
def test_rendering_that_is_cut_off_while_it_refuses_ends_as_undisturbed(
    mixed: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusals: int
) -> None:
    stage, left = anew(mixed, tmp_path), [refusals]

    def cut_off(path: Path, refusal: Refusal) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise KeyboardInterrupt
        write(path, refusal)

    write = jobs.write_refusal
    monkeypatch.setattr(jobs, "write_refusal", cut_off)
    with pytest.raises(KeyboardInterrupt):
        stage.run(Recorder())
    monkeypatch.undo()
    stage.run(Recorder())
    assert contents(stage.workspace.scans) == contents(mixed.workspace.scans)


def with_joints(stage: Render, folder: Path, joints: str) -> Render:
    """The same in a copy of the workspace, of objects with some joints."""
    config = folder / "joints.toml"
    config.write_text(Path(stage.config).read_text(encoding="utf-8").replace("[scans]", f"[scans]\njoints = {joints}"), "utf-8")
    shutil.copytree(stage.workspace.path, folder / "workspace")
    return Render(Workspace(folder / "workspace"), str(config), FAMILY)


def test_objects_with_the_joints_that_the_configuration_names_are_scanned_and_no_others(mixed: Render, tmp_path: Path) -> None:
    train = [open_scans(path) for path in scans_of(mixed.workspace, CATEGORY, "train").glob("*.safetensors")]
    usual = dataset_of(mixed).structure
    rare = next(file.structure for file in train if file.structure != usual)
    named = [f"{kind.value} on {parent}" for kind, parent in zip(rare.kinds, rare.parents, strict=True)]
    stage = with_joints(mixed, tmp_path, str(named))
    told = stage.run(Recorder())
    assert stage.plan().steps == ()
    dataset = dataset_of(stage)
    assert dataset.structure == rare
    assert set(told.data["categories"][CATEGORY]["structures"]) == {str(rare)}
    assert told.data["categories"][CATEGORY]["not scanned"][str(usual)] > 1
    assert dataset.others[str(usual), "train", "partnet_mobility"] >= 1


def test_joints_that_no_labelled_object_has_leave_nothing_to_train_on_and_those_there_are_are_told(
    mixed: Render, tmp_path: Path
) -> None:
    stage = with_joints(mixed, tmp_path, '["PR on 0", "PR on 1"]')
    told = stage.run(Recorder())
    assert not told.data["categories"][CATEGORY]["objects"]
    with pytest.raises(
        InputError, match=r"labelled shape to train on; those there are have .* not the joints of scans\.joints"
    ) as error:
        dataset_of(stage)
    assert str(dataset_of(mixed).structure) in str(error.value)


@pytest.mark.parametrize("joints", ['["R"]', '["R on 1"]', '["revolute on 0"]', '["R on 0", "P on 2"]'])
def test_what_is_no_joint_is_told(mixed: Render, tmp_path: Path, joints: str) -> None:
    with pytest.raises(InputError, match=r"scans\.joints: expected R, P, PR on a part before part \d, such as R on 0"):
        with_joints(mixed, tmp_path, joints).run(Recorder())
