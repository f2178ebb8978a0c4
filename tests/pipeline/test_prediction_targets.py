"""Shapes are found in files and folders, and each gets a folder of its own."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from cabinet_results import result_in
from datasets import write_partnet
from trained_workspace import Recorder

from kinmo.core.errors import InputError
from kinmo.pipeline.export_results import ExportResults
from kinmo.pipeline.prediction_targets import prediction_targets


def names_of(sources: list[Path], out: Path) -> list[str]:
    targets, problems = prediction_targets(sources, out)
    assert problems == []
    assert all(folder.parent == out for _, folder in targets)
    return [folder.name for _, folder in targets]


def test_shapes_of_several_sources_stand_in_one_folder(tmp_path: Path) -> None:
    for place in ("a/door", "b/lid", "b/box"):
        write_partnet(tmp_path / place)
    assert names_of([tmp_path / "b", tmp_path / "a/door"], tmp_path / "out") == ["box", "lid", "door"]


def test_a_shape_that_two_sources_hold_counts_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_partnet(tmp_path / "a/door")
    monkeypatch.chdir(tmp_path)
    assert names_of([Path("a"), tmp_path / "a/door", Path("a/../a")], tmp_path / "out") == ["door"]


def test_shapes_of_one_name_are_named_after_the_folders_that_differ(tmp_path: Path) -> None:
    for place in ("a/door", "b/door"):
        write_partnet(tmp_path / place)
    assert names_of([tmp_path / "a/door", tmp_path / "b/door"], tmp_path / "out") == ["a__door", "b__door"]


def test_names_within_a_folder_do_not_depend_on_other_shapes(tmp_path: Path) -> None:
    for place in ("x/a/door", "x/b/door"):
        write_partnet(tmp_path / place)
    assert names_of([tmp_path], tmp_path / "out") == ["x__a__door", "x__b__door"]


def test_a_source_without_shapes_stops_no_other(tmp_path: Path) -> None:
    write_partnet(tmp_path / "a/door")
    (tmp_path / "empty").mkdir()
    targets, problems = prediction_targets([tmp_path / "none", tmp_path / "a", tmp_path / "empty"], tmp_path / "out")
    assert [folder.name for _, folder in targets] == ["door"]
    assert problems[0] == f"{tmp_path / 'none'}: no such file or folder"
    assert problems[1].startswith(f"{tmp_path / 'empty'}: expected at least one shape")
    with pytest.raises(InputError, match="empty: expected at least one shape"):
        prediction_targets([tmp_path / "empty"], tmp_path / "out")


def test_results_are_no_shapes_and_the_message_says_so(tmp_path: Path) -> None:
    result = result_in(tmp_path)
    assert ExportResults(result, ("urdf", "mjcf")).run(Recorder()).failed == 0
    problem = "has results of kinmo predict, but no other shape: kinmo export writes results again"
    for source in (result, result.parent):
        for out in (tmp_path / "predicted", result.parent):
            with pytest.raises(InputError, match=f"{source}: {problem}"):
                prediction_targets([source], out)


POINTS = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"


def test_scans_and_empty_files_among_shapes_are_skipped(tmp_path: Path) -> None:
    write_partnet(tmp_path / "a/door")
    (tmp_path / "cloud.ply").write_text(POINTS)
    (tmp_path / "empty.npz").touch()
    targets, problems = prediction_targets([tmp_path / "cloud.ply", tmp_path / "empty.npz", tmp_path / "a"], tmp_path / "out")
    assert [folder.name for _, folder in targets] == ["door"]
    assert problems == [
        f"{tmp_path / 'cloud.ply'}: is a scan, without faces: predict scans in a command of their own, with --category",
        f"{tmp_path / 'empty.npz'}: is empty: write it again",
    ]


@pytest.mark.parametrize("name", ["locked.ply", "locked.xml", "locked.npz"])
def test_a_file_that_cannot_be_read_stops_no_other(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_partnet(tmp_path / "a/door")
    (tmp_path / name).write_text(POINTS)
    opened = os.open

    def refusing(path: str, flags: int, *rest: int) -> int:
        if Path(path).name == name:
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, flags, *rest)

    monkeypatch.setattr(os, "open", refusing)
    targets, problems = prediction_targets([tmp_path / name, tmp_path / "a"], tmp_path / "out")
    assert [folder.name for _, folder in targets] == ["door"]
    assert problems == [f"{tmp_path / name}: cannot be read (Permission denied)"]


def test_a_file_in_a_folder_that_must_not_be_searched_stops_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_partnet(tmp_path / "a/door")
    looked = Path.is_dir

    def refusing(path: Path) -> bool:
        if "locked" in path.parts:
            raise PermissionError(13, "Permission denied", str(path))
        return looked(path)

    monkeypatch.setattr(Path, "is_dir", refusing)
    targets, problems = prediction_targets([tmp_path / "locked/a.glb", tmp_path / "a"], tmp_path / "out")
    assert [folder.name for _, folder in targets] == ["door"]
    assert problems == [f"{tmp_path / 'locked/a.glb'}: cannot be read (Permission denied)"]
