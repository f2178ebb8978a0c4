"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kinmo.core.errors import InputError

_TEMPORARY = ".{name}.tmp~"
_REPLACED = ".{name}.old~"


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Gives a place to write a file or a folder, and moves it to `path` once the block is done.

    Whatever happens in between, `path` is what it was before, or (for a folder that is replaced) absent, or whole. The
    temporary place has a fixed name beside `path`, so that a run that was killed leaves nothing that the next one does not
    clear away.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.parent / _TEMPORARY.format(name=path.name)
    replaced = path.parent / _REPLACED.format(name=path.name)
    _remove(temporary)
    try:
        yield temporary
        if not os.path.lexists(temporary):
            raise FileNotFoundError(f"nothing was written to {temporary}")
        _sync(temporary)
        if path.is_dir() and not path.is_symlink():
            _remove(replaced)
            path.rename(replaced)
        temporary.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        if error.errno is not None and error.filename in (None, str(temporary)):  # writing to a full disk names no file
            error.filename = str(path)
        raise
    finally:
        _remove(temporary)
        _remove(replaced)


def write_text_atomically(path: Path, text: str) -> None:
    """Writes a UTF-8 file with `write_atomically`; one that has this text already is left alone."""
    write_bytes_atomically(path, text.encode("utf-8"))


def write_bytes_atomically(path: Path, data: bytes) -> None:
    """Writes a file with `write_atomically`; one that has these contents already is left alone."""
    if _contents(path) == data:
        return
    with write_atomically(path) as temporary:
        temporary.write_bytes(data)


def check_can_be_written(folder: Path) -> None:
    """Raises InputError if nothing can be written to a folder, or it cannot be made; makes nothing."""
    there = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
    if not there.is_dir():
        raise InputError(folder, "expected a folder: this is a file" if there == folder else f"{there} is a file, not a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(folder, "cannot be written to")


def remove_leftovers(folder: Path) -> None:
    """Clears away what runs that were killed left in `folder` and below. Only for the holder of the workspace's lock."""
    for pattern in (_TEMPORARY, _REPLACED):
        for path in Path(folder).rglob(pattern.format(name="*")):
            _remove(path)


def _contents(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except OSError:
        return None


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Brings a file, or all of a folder, to the disk."""
    if path.is_dir():
        for below in path.rglob("*"):
            if below.is_file():
                _sync_file(below)
    else:
        _sync_file(path)


def _sync_file(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _sync_folder(path: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def append_line(path: Path, line: str) -> None:
    """Append a line of UTF-8 text to a file; a last line that a killed process left unfinished is ended first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as file:
        begun = b""
        if file.seek(0, os.SEEK_END):
            file.seek(-1, os.SEEK_END)
            begun = b"" if file.read(1) == b"\n" else b"\n"
        file.write(begun + line.encode("utf-8") + b"\n")
