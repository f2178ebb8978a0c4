"""Scans on disk."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinmo.config import ScansConfig
from kinmo.core.errors import InputError
from kinmo.scans.labelled_frames import Scans, scan
from kinmo.scans.scan_file import Provenance, open_scans, write_scans
from scanned import cupboard_object, scans_in

CONFIG = ScansConfig(states=2, views=2, size=64, points=50)


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    target = cupboard_object()
    scans = scan(target, CONFIG, 0)
    path = tmp_path / "cupboard.safetensors"
    write_scans(path, target, scans, Provenance("here"))
    file = open_scans(path)
    assert (file.id, file.category, file.frames) == (target.id, target.category, len(scans))
    assert file.structure == target.structure
    assert file.provenance == Provenance("here")
    np.testing.assert_array_equal(file.extents.sizes, target.part_extents.sizes)
    for mine, theirs in zip(file.joints, target.joints, strict=True):
        assert (mine.kind, mine.lower, mine.upper) == (theirs.kind, theirs.lower, theirs.upper)
        np.testing.assert_array_equal(mine.direction, theirs.direction)
    back = scans_in(file)
    for name in ("points", "parts", "places", "poses", "values", "turns"):
        np.testing.assert_array_equal(getattr(back, name), getattr(scans, name))
        np.testing.assert_array_equal(file.read(name, 0), getattr(scans, name)[0])
    assert back.refused == scans.refused


def test_whoever_opens_a_file_changes_it_for_nobody_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kinmo.io.file_memo._SETTLED", -1)
    target, path = cupboard_object(), tmp_path / "cupboard.safetensors"
    write_scans(path, target, scan(target, CONFIG, 0), Provenance("here"))
    one, other = open_scans(path), open_scans(path)
    one.refused["unseen"] = 1  # type: ignore[index]
    assert "unseen" not in {*other.refused, *open_scans(path).refused}
    for array in (one.facing, one.extents.sizes, one.extents.centers, one.joints[0].direction, one.joints[0].pivot):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    write_scans(path, target, scan(target, CONFIG, 1), Provenance("elsewhere"))
    assert open_scans(path).provenance == Provenance("elsewhere")


def test_the_same_frames_give_the_same_bytes(tmp_path: Path) -> None:
    target = cupboard_object()
    for name in ("one", "two"):
        write_scans(tmp_path / name, target, scan(target, CONFIG, 3), Provenance())
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_an_object_without_a_frame_can_be_kept_too(tmp_path: Path) -> None:
    target = cupboard_object()
    scans: Scans = scan(target, ScansConfig(states=1, views=1, size=64, points=50, least_pixels=10_000), 0)
    write_scans(tmp_path / "none", target, scans, Provenance())
    file = open_scans(tmp_path / "none")
    assert file.frames == 0
    assert sum(file.refused.values()) == 1


@pytest.mark.parametrize("content", [b"", b"no safetensors", None])
def test_what_is_no_file_of_scans_is_refused_with_its_path(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "file.safetensors"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=r"file\.safetensors"):
        open_scans(path)


def test_a_file_that_was_cut_is_refused(tmp_path: Path) -> None:
    target = cupboard_object()
    path = tmp_path / "cut.safetensors"
    write_scans(path, target, scan(target, CONFIG, 0), Provenance())
    path.write_bytes(path.read_bytes()[:-10])
    with pytest.raises(InputError, match="run kinmo render again"):
        open_scans(path)
