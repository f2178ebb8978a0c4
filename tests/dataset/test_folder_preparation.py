"""Folders of shapes are prepared once, resumably, and with a reason for every skipped shape."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from datasets import write_dsg_net, write_json, write_partnet, write_partnet_mobility

from kinmo.core.errors import InputError
from kinmo.dataset.cache import FILE
from kinmo.dataset.folder_preparation import prepare_folder
from kinmo.dataset.stage import SilentObserver
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.discover import ShapeSource
from kinmo.synth.synth_stage import Synth

SHAPES = 6


@pytest.fixture
def dataset(tmp_path) -> Path:
    """Some shapes of each layout, one to be repaired, and one that is broken."""
    root = tmp_path / "partnet"
    for number in range(SHAPES // 2):
        write_partnet_mobility(root / "mobility" / str(100 + number))
        write_partnet(root / "plain" / str(100 + number))
    write_dsg_net(root / "generated", "1")
    write_partnet_mobility(root / "mobility" / "200", meta={"model_cat": "Box"})
    write_partnet_mobility(root / "mobility" / "300", [])
    return root


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name != FILE
    }


def prepare(root: Path, workspace: Path, **options):
    return prepare_folder(root, Workspace(workspace), points=16, **options)


def test_every_shape_is_included_repaired_or_skipped_with_a_reason(dataset, tmp_path):
    report = prepare(dataset, tmp_path / "w").as_data()
    assert list(report) == ["included", "repaired", "skipped"]
    assert len(report["included"]) == SHAPES + 1
    assert [entry["id"] for entry in report["repaired"]] == ["200"]
    assert [entry["id"] for entry in report["skipped"]] == ["300"]
    assert "mobility_v2.json" in report["skipped"][0]["reasons"][0]
    assert all(set(entry) == {"id", "path", "reasons"} for entries in report.values() for entry in entries)
    json.dumps(report)


def test_pseudo_labels_are_not_annotations(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    write_partnet_mobility(dataset / "mobility" / "100", meta={"pseudo_label": {"method": "kinmo"}})
    report = prepare(dataset, tmp_path / "w").as_data()
    (entry,) = [entry for entry in report["skipped"] if entry["id"] == "100"]
    assert entry["reasons"][0].startswith(
        f"{dataset / 'mobility' / '100' / 'meta.json'}: pseudo_label: these joints were predicted"
    )
    assert len(PreparedStore(tmp_path / "w" / "prepared")) == SHAPES + 1


def test_the_store_holds_all_included_shapes(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    store = PreparedStore(tmp_path / "w" / "prepared")
    assert len(store) == SHAPES + 2
    for entry in store.entries:
        shape = store.load(entry)
        assert (shape.id, shape.layout, shape.category) == (entry.id, entry.layout, entry.category)
        assert entry.is_labelled == (entry.layout == "partnet_mobility")
        assert len(shape.leaves) == entry.leaf_count
        assert Path(entry.source).exists()
    counted = [entry.joint_count for entry in store.entries if entry.is_labelled]
    assert counted == [2] * len(counted)


def test_the_number_of_workers_changes_nothing(dataset, tmp_path):
    reports = [prepare(dataset, tmp_path / f"w{workers}", workers=workers).as_data() for workers in (1, 2)]
    assert reports[0] == reports[1]
    assert contents(tmp_path / "w1") == contents(tmp_path / "w2")


def test_a_second_run_prepares_nothing_and_reports_the_same(dataset, tmp_path):
    first = prepare(dataset, tmp_path / "w")
    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "w" / "prepared").rglob("*")}
    second = prepare(dataset, tmp_path / "w")
    assert (first.new, second.new) == (SHAPES + 2, 0)
    assert second.as_data() == first.as_data()
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "w" / "prepared").rglob("*")} == times


def test_changed_shapes_are_prepared_again_and_broken_ones_removed(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    path = dataset / "plain" / "100" / "objs" / "original-6.obj"
    path.write_text(path.read_text().replace("0.48", "0.47"))
    (dataset / "plain" / "101" / "result.json").write_text("[", encoding="utf-8")
    report = prepare(dataset, tmp_path / "w")
    assert report.new == 1
    assert [Path(entry.path).name for entry in report.skipped] == ["300", "101"]
    assert len(PreparedStore(tmp_path / "w" / "prepared")) == SHAPES + 1
    assert not (tmp_path / "w" / "prepared" / "partnet" / "101.safetensors").exists()


def test_other_seeds_and_numbers_of_points_are_prepared_again(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    assert prepare(dataset, tmp_path / "w", seed=1).new == SHAPES + 2
    assert prepare_folder(dataset, Workspace(tmp_path / "w"), points=8, seed=1).new == SHAPES + 2


def test_identical_copies_are_included_once_and_different_ones_reported(dataset, tmp_path):
    shutil.copytree(dataset / "plain" / "100", dataset / "z" / "100")
    shutil.copytree(dataset / "plain" / "101", dataset / "z" / "101")
    write_json(dataset / "z" / "101" / "meta.json", {"model_cat": "Table"})
    report = prepare(dataset, tmp_path / "w")
    taken = {Path(entry.path).relative_to(dataset).as_posix(): entry.reasons for entry in report.included}
    assert "identical copy" in taken["plain/100"][0] and "z/100" in taken["plain/100"][0]
    assert "z/100" not in taken
    out = {Path(entry.path).relative_to(dataset).as_posix(): entry.reasons for entry in report.skipped}
    assert "differs from another copy" in out["z/101"][0]
    assert taken["plain/101"] == ()


def test_a_copy_is_read_instead_of_an_unreadable_shape(dataset, tmp_path):
    for name, category in (("x", "Table"), ("y", "Table"), ("z", "Chair")):
        shutil.copytree(dataset / "plain" / "100", dataset / name / "100")
        write_json(dataset / name / "100" / "meta.json", {"model_cat": category})
    (dataset / "plain" / "100" / "result.json").write_text("[")
    for made in (SHAPES + 2, 0):
        report = prepare(dataset, tmp_path / "w")
        assert report.new == made
        taken = {Path(e.path).relative_to(dataset).as_posix(): e.reasons for e in (*report.included, *report.repaired)}
        assert taken.keys() & {"plain/100", "x/100", "y/100", "z/100"} == {"x/100"}
        assert taken["x/100"][-1] == f"identical copy skipped: {dataset / 'y' / '100'}"
        out = {Path(entry.path).relative_to(dataset).as_posix(): entry.reasons for entry in report.skipped}
        assert "not JSON" in out["plain/100"][0]
        assert out["z/100"][0].endswith(f"which is read instead: {dataset / 'x' / '100'}")


def test_copies_of_a_shape_that_crashed_are_skipped(dataset, tmp_path, monkeypatch):
    shutil.copytree(dataset / "plain" / "100", dataset / "z" / "100")
    write_json(dataset / "z" / "100" / "meta.json", {"model_cat": "Chair"})

    def unforeseen(shape, **how):
        if shape.id == "100" and shape.layout == "partnet":
            raise RuntimeError("no such axis")
        return prepare_shape(shape, **how)

    monkeypatch.setattr("kinmo.dataset.folder_preparation.prepare_shape", unforeseen)
    report = prepare(dataset, tmp_path / "w")
    out = {Path(entry.path).relative_to(dataset).as_posix(): entry.reasons for entry in report.skipped}
    assert "cannot be prepared: RuntimeError" in out["plain/100"][0]
    assert out["z/100"] == ("differs from another copy of 100, which cannot be prepared",)


def test_the_same_id_in_two_layouts_is_two_shapes(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    found = {(entry.layout, entry.id) for entry in PreparedStore(tmp_path / "w" / "prepared").entries}
    assert {("partnet", "100"), ("partnet_mobility", "100")} <= found


def test_links_are_followed(dataset, tmp_path):
    write_partnet(tmp_path / "elsewhere" / "1")
    (dataset / "link").symlink_to(tmp_path / "elsewhere")
    report = prepare(dataset, tmp_path / "w")
    assert str(dataset / "link" / "1") in {entry.path for entry in report.included}


def test_a_workspace_among_the_shapes_is_not_searched(dataset, tmp_path):
    write_partnet(dataset / "workspace" / "pseudo_labels" / "900")
    report = prepare(dataset, dataset / "workspace")
    assert "900" not in {entry.id for entry in report.included}


def test_pseudo_labels_in_another_workspace_are_no_shapes(dataset, tmp_path):
    prepare(dataset, tmp_path / "partnet" / "other")
    write_partnet_mobility(tmp_path / "partnet" / "other" / "pseudo_labels" / "kinmo" / "900")
    report = prepare(dataset, tmp_path / "w")
    assert len(report.included) == SHAPES + 1
    assert "900" not in {entry.id for entry in report.included}


def test_a_copy_that_cannot_be_read_does_not_stop_the_others(dataset, tmp_path, monkeypatch):
    shutil.copytree(dataset / "plain" / "100", dataset / "z" / "100")

    def unreadable(found: ShapeSource) -> str:
        raise InputError(found.path, "cannot be read (Permission denied)")

    monkeypatch.setattr("kinmo.io.source_files.content_digest", unreadable)
    report = prepare(dataset, tmp_path / "w")
    assert len(report.included) == SHAPES + 1
    assert [Path(entry.path).name for entry in report.skipped] == ["300", "100"]


def test_a_shape_is_oracle_by_its_own_folder_too(dataset, tmp_path):
    prepare(dataset, tmp_path / "w", oracle=[dataset / "mobility" / "101"])
    entries = PreparedStore(tmp_path / "w" / "prepared").entries
    assert [(entry.id, entry.layout) for entry in entries if entry.is_oracle] == [("101", "partnet_mobility")]


def test_a_shape_changes_with_the_target_of_a_link(dataset, tmp_path):
    mesh = next((dataset / "plain" / "100").glob("*objs/*.obj"))
    target = mesh.parent.parent / "raw.obj"
    mesh.rename(target)
    mesh.symlink_to(target)
    assert prepare(dataset, tmp_path / "w").new == SHAPES + 2
    target.write_text(target.read_text() + "v 0 0 0\n")
    assert prepare(dataset, tmp_path / "w").new == 1


def test_shapes_in_the_workspace_itself_are_not_prepared(dataset):
    with pytest.raises(InputError, match=r"lies in the workspace .* name another --workspace"):
        prepare(dataset, dataset)
    assert not (dataset / ".lock").exists()


def test_a_workspace_is_no_folder_of_shapes(dataset, tmp_path):
    prepare(dataset, tmp_path / "w")
    with pytest.raises(InputError, match="is a workspace, which is skipped: expected the folder with the shapes"):
        prepare(tmp_path / "w", tmp_path / "other")
    assert not (tmp_path / "other").exists()
    for ask in (Synth(tmp_path / "w", 1).plan, partial(Synth(tmp_path / "w", 1).run, SilentObserver())):
        with pytest.raises(InputError, match="is a workspace, in which no shapes are looked for"):
            ask()


def test_a_shape_with_unreadable_files_is_skipped_with_one_line(dataset, tmp_path, monkeypatch):
    real = os.scandir

    def denied(path):
        if Path(path).name == "objs" and Path(path).parent == first:
            raise PermissionError(13, "Permission denied", str(path))
        return real(path)

    first = sorted(path.parent for path in dataset.rglob("objs"))[0]
    monkeypatch.setattr("kinmo.io.source_files.os.scandir", denied)
    report = prepare(dataset, tmp_path / "w")
    (left_out,) = (entry for entry in report.skipped if entry.path == str(first))
    assert left_out.reasons == (f"{first / 'objs'}: cannot be read (Permission denied)",)


def test_odd_names_are_prepared(tmp_path):
    names = [os.fsdecode(b"bad\xff"), "a b%2F", "é" * 60, "line\nbreak", "con", "x.y"]
    for name in names:
        write_partnet(tmp_path / "data" / name)
    report = prepare(tmp_path / "data", tmp_path / "w")
    assert len(report.included) == len(names)
    assert len(PreparedStore(tmp_path / "w" / "prepared")) == len(names)
    json.dumps(report.as_data(), ensure_ascii=False).encode("utf-8")


def test_progress_counts_to_the_number_of_shapes(dataset, tmp_path):
    seen = []
    prepare(dataset, tmp_path / "w", on_progress=lambda done, total, name: seen.append((done, total)))
    assert seen == [(number, SHAPES + 3) for number in range(1, SHAPES + 4)]


def test_a_folder_without_shapes_is_an_error_and_leaves_the_index_alone(dataset, tmp_path):
    (tmp_path / "empty").mkdir()
    prepare(dataset, tmp_path / "w")
    before = (tmp_path / "w" / "prepared" / "index.jsonl").read_bytes()
    for folder in ("empty", "missing"):
        with pytest.raises(InputError, match=folder):
            prepare(tmp_path / folder, tmp_path / "w")
    assert (tmp_path / "w" / "prepared" / "index.jsonl").read_bytes() == before


def test_a_run_that_is_killed_and_repeated_ends_like_one_that_was_not(dataset, tmp_path):
    for number in range(20):
        write_partnet_mobility(dataset / "more" / str(500 + number))
    prepare(dataset, tmp_path / "whole")
    script = (
        "import sys\n"
        "from pathlib import Path\n"
        "from kinmo.dataset.folder_preparation import prepare_folder\n"
        "from kinmo.dataset.workspace import Workspace\n"
        "if __name__ == '__main__':\n"
        "    print('start', flush=True)\n"
        "    prepare_folder(Path(sys.argv[1]), Workspace(sys.argv[2]), points=16, workers=int(sys.argv[3]))\n"
    )
    (tmp_path / "run.py").write_text(script)
    rng = random.Random(0)
    for workers in (1, 2):
        command = [sys.executable, str(tmp_path / "run.py"), str(dataset), str(tmp_path / "cut"), str(workers)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True) as process:
            process.stdout.readline()
            time.sleep(rng.uniform(0.0, 1.0 if workers > 1 else 0.3))
            process.send_signal(signal.SIGKILL)
    prepare(dataset, tmp_path / "cut")
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")
