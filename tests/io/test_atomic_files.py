"""Atomic writing: a file or folder appears whole or not at all."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.io.atomic_files import (
    append_line,
    check_can_be_written,
    remove_leftovers,
    restore_replaced,
    write_atomically,
    write_bytes_atomically,
    write_folder_atomically,
    write_text_atomically,
)


def names_in(folder: Path) -> list[str]:
    return [entry.name for entry in folder.iterdir()]


def test_a_file_appears_only_when_it_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "file.txt"
    with write_atomically(path) as draft:
        draft.write_text("half")
        assert not path.exists()
    assert path.read_text() == "half"
    with pytest.raises(RuntimeError), write_atomically(path) as draft:
        draft.write_text("other")
        raise RuntimeError
    assert path.read_text() == "half"
    assert names_in(path.parent) == ["file.txt"]


def test_a_folder_is_replaced_as_a_whole(tmp_path: Path) -> None:
    path = tmp_path / "folder"
    for name in ("one", "two"):
        with write_folder_atomically(path) as draft:
            (draft / name).write_text(name)
    assert names_in(path) == ["two"]
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_cannot_be_removed_is_left_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    meshes = tmp_path / "result" / "meshes"
    meshes.mkdir(parents=True)
    monkeypatch.setattr("kinmo.io.atomic_files.os.access", lambda path, mode: Path(path) != meshes)  # root may write everywhere
    with pytest.raises(PermissionError) as caught, write_folder_atomically(tmp_path / "result"):
        pytest.fail("nothing is to be written")
    assert caught.value.filename == str(meshes)
    assert [path.name for path in tmp_path.iterdir()] == ["result"] and meshes.is_dir()


def test_drafts_of_killed_runs_are_removed(tmp_path: Path) -> None:
    script = (
        "import os, sys; from pathlib import Path; from kinmo.io.atomic_files import write_atomically\n"
        "with write_atomically(Path(sys.argv[1]) / 'f') as t:\n"
        "    t.write_text('x' * 1000); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == 1, "the killed run left a draft"
    assert not (tmp_path / "f").exists()
    write_text_atomically(tmp_path / "f", "y")
    assert names_in(tmp_path) == ["f"]
    (tmp_path / ".g.tmp~").mkdir()
    (tmp_path / ".g.tmp~" / "h").write_text("")
    remove_leftovers(tmp_path)
    assert names_in(tmp_path) == ["f"]


def test_an_interrupt_while_a_folder_is_replaced_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = tmp_path / "result"
    result.mkdir()
    (result / "overrides.toml").write_text("mine")

    def interrupted(self: Path, target: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", interrupted)
        with pytest.raises(KeyboardInterrupt), write_folder_atomically(result):
            pass
    assert names_in(tmp_path) == ["result"] and names_in(result) == ["overrides.toml"]


@pytest.mark.parametrize("remedy", [restore_replaced, remove_leftovers])
def test_a_folder_that_a_killed_run_was_replacing_comes_back(tmp_path: Path, remedy: Callable[[Path], None]) -> None:
    for folder in (".result.old~", ".other.old~", "other"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "file").write_text(folder)
    remedy(tmp_path)
    assert (tmp_path / "result" / "file").read_text() == ".result.old~"
    assert (tmp_path / "other" / "file").read_text() == "other"
    with write_folder_atomically(tmp_path / "other") as draft:
        (draft / "new").touch()
    assert names_in(tmp_path / "other") == ["new"]


def test_links_and_read_only_files_in_a_folder_are_no_obstacle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").write_text("")
    modes = {}

    def flushed(path: Path, mode: int) -> None:
        modes[path.name] = mode

    monkeypatch.setattr("kinmo.io.atomic_files._flush", flushed)
    with write_folder_atomically(tmp_path / "result") as draft:  # root may write read-only files: look at the modes instead
        (draft / "read_only").touch(0o444)
        (draft / "link").symlink_to(tmp_path / "elsewhere")
        (draft / "broken").symlink_to(tmp_path / "nowhere")
    assert modes == {"read_only": os.O_RDONLY, tmp_path.name: os.O_RDONLY}
    assert sorted(names_in(tmp_path / "result")) == ["broken", "link", "read_only"]


def test_a_file_with_the_right_contents_is_not_touched(tmp_path: Path) -> None:
    path = tmp_path / "f"
    write_text_atomically(path, "é\n")
    assert path.read_bytes() == "é\n".encode()
    before = path.stat()
    write_text_atomically(path, "é\n")
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)
    write_text_atomically(path, "e\n")
    assert path.read_text() == "e\n"


def test_a_block_that_writes_nothing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), write_atomically(tmp_path / "f"):
        pass


def test_a_full_disk_names_the_file_and_leaves_the_old_one(tmp_path: Path) -> None:
    write_bytes_atomically(tmp_path / "file", b"before")
    with (
        pytest.raises(OSError, match=r"No space left on device: .*file") as raised,
        write_atomically(tmp_path / "file") as draft,
    ):
        draft.write_bytes(b"half of")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert raised.value.filename == str(tmp_path / "file")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"before"]


def test_an_error_names_the_file_and_not_its_draft(tmp_path: Path) -> None:
    with pytest.raises(OSError) as caught, write_atomically(tmp_path / "a.json") as draft:
        draft.mkdir()
        draft.write_text("a file where there is a folder")
    assert caught.value.filename == str(tmp_path / "a.json")


def test_a_line_is_appended_after_an_unfinished_one(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "log"
    append_line(path, "one")
    append_line(path, "zwö")
    with path.open("ab") as file:
        file.write(b"cut o")
    append_line(path, "three")
    assert path.read_text(encoding="utf-8").splitlines() == ["one", "zwö", "cut o", "three"]


def test_a_folder_is_checked_without_creating_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check_can_be_written(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file: expected a folder: this is a file"):
        check_can_be_written(tmp_path / "file")
    with pytest.raises(InputError, match=r"below: .*file is a file, not a folder"):
        check_can_be_written(tmp_path / "file" / "below")
    monkeypatch.setattr("kinmo.io.atomic_files.os.access", lambda path, mode: False)  # root may write everywhere
    with pytest.raises(InputError, match="new: cannot be written to"):
        check_can_be_written(tmp_path / "new")
