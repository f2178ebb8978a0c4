"""The cache for values read from files."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinmo.io.atomic_files import write_bytes_atomically
from kinmo.io.file_memo import kept_while_unchanged


def test_a_file_is_read_again_only_after_it_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("kinmo.io.file_memo._MIN_AGE", -1)
    path, reads = tmp_path / "file", []

    @kept_while_unchanged
    def text(path: Path) -> str:
        reads.append(path)
        return path.read_text(encoding="utf-8")

    with pytest.raises(FileNotFoundError):
        text(path)
    reads.clear()
    for count, contents in enumerate(("a", "longer", "b"), start=1):
        write_bytes_atomically(path, contents.encode())
        assert [text(path), text(path), text(Path(str(path)))] == [contents] * 3
        assert len(reads) == count
    path.unlink()
    with pytest.raises(FileNotFoundError):
        text(path)


def test_the_value_of_a_file_that_has_just_changed_is_not_cached(tmp_path: Path) -> None:
    path, first_byte = tmp_path / "file", kept_while_unchanged(lambda path: path.read_bytes()[:1])
    for contents in (b"a", b"b", b"c") * 20:
        path.write_bytes(contents)
        assert first_byte(path) == contents
