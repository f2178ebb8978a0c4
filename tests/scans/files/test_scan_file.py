"""Labelled frames on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scanned_objects import cupboard_object, read_frames

from kinmo.config import ScansConfig
from kinmo.core.errors import InputError
from kinmo.scans.files.scan_file import ScanProvenance, open_scans, write_scans
from kinmo.scans.rendering.labelled_frames import LabelledFrames, scan_object

CONFIG = ScansConfig(states=2, views=2, size=64, points=50)


def test_frames_are_read_as_written(tmp_path: Path) -> None:
    target = cupboard_object()
    scans = scan_object(target, CONFIG, 0)
    path = tmp_path / "cupboard.safetensors"
    write_scans(path, target, scans, ScanProvenance("here"))
    file = open_scans(path)
    assert (file.id, file.category, file.frames) == (target.id, target.category, len(scans))
    assert file.structure == target.structure
    assert file.provenance == ScanProvenance("here")
    np.testing.assert_array_equal(file.extents.sizes, target.part_extents.sizes)
    for mine, theirs in zip(file.joints, target.joints, strict=True):
        assert (mine.kind, mine.lower, mine.upper) == (theirs.kind, theirs.lower, theirs.upper)
        np.testing.assert_array_equal(mine.direction, theirs.direction)
    back = read_frames(file)
    for name in ("points", "parts", "places", "poses", "values", "turns"):
        np.testing.assert_array_equal(getattr(back, name), getattr(scans, name))
        np.testing.assert_array_equal(file.read(name, 0), getattr(scans, name)[0])
    assert back.skipped == scans.skipped


def test_opened_files_are_independent_and_read_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kinmo.io.file_memo._MIN_AGE", -1)
    target, path = cupboard_object(), tmp_path / "cupboard.safetensors"
    write_scans(path, target, scan_object(target, CONFIG, 0), ScanProvenance("here"))
    one, other = open_scans(path), open_scans(path)
    one.skipped["invisible"] = 1  # type: ignore[index]
    assert "invisible" not in {*other.skipped, *open_scans(path).skipped}
    for array in (
        one.axis_aligned_shares,
        one.extents.sizes,
        one.extents.centers,
        one.joints[0].direction,
        one.joints[0].pivot,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    write_scans(path, target, scan_object(target, CONFIG, 1), ScanProvenance("elsewhere"))
    assert open_scans(path).provenance == ScanProvenance("elsewhere")


def test_equal_frames_give_equal_bytes(tmp_path: Path) -> None:
    target = cupboard_object()
    for name in ("one", "two"):
        write_scans(tmp_path / name, target, scan_object(target, CONFIG, 3), ScanProvenance())
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_an_object_without_frames_can_be_written(tmp_path: Path) -> None:
    target = cupboard_object()
    scans: LabelledFrames = scan_object(target, ScansConfig(states=1, views=1, size=64, points=50, least_pixels=10_000), 0)
    write_scans(tmp_path / "none", target, scans, ScanProvenance())
    file = open_scans(tmp_path / "none")
    assert file.frames == 0
    assert sum(file.skipped.values()) == 1


@pytest.mark.parametrize("content", [b"", b"no safetensors", None])
def test_another_file_is_an_error_that_names_it(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "file.safetensors"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"file\.safetensors"):
        open_scans(path)


def test_a_truncated_file_is_an_error(tmp_path: Path) -> None:
    target = cupboard_object()
    path = tmp_path / "cut.safetensors"
    write_scans(path, target, scan_object(target, CONFIG, 0), ScanProvenance())
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(InputError, match="run kinmo render again"):
        open_scans(path)
