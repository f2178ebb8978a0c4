"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError

_TEMPORARY = ".{name}.tmp~"
"""Name of the draft beside the result."""
_REPLACED = ".{name}.old~"
"""Name of the replaced folder while the draft takes its place."""
_SYNCED_AT_ONCE = 8
"""Files of a folder that are flushed at once: disks write them together, several times as fast."""


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Write a file or a folder to a draft, which replaces `path` when the block ends without an error.

    If the block fails, `path` is unchanged. A folder may be absent while it is being replaced. The draft has a fixed name
    beside `path`: the next run removes what a killed run left, and brings back a folder that was absent then
    (`restore_replaced`). Parent folders are created.

    Yields the path of the draft. Raises FileNotFoundError if the block wrote nothing. Other OSErrors name `path`.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    _check_removable(path)
    temporary = path.parent / _TEMPORARY.format(name=path.name)
    replaced = path.parent / _REPLACED.format(name=path.name)
    _restore(replaced)
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
        if error.errno is not None and error.filename in (None, str(temporary)):  # a full disk gives an error without a name
            error.filename = str(path)
        raise
    finally:
        _restore(replaced)
        _remove(temporary)
        _remove(replaced)


@contextmanager
def write_folder_atomically(folder: Path) -> Iterator[Path]:
    """Write a folder with `write_atomically`. Yields an empty draft folder, which replaces `folder` as a whole."""
    with write_atomically(folder) as draft:
        draft.mkdir()
        yield draft


def write_json_atomically(path: Path, data: Any, *, sort_keys: bool = False, allow_nan: bool = True) -> None:
    """Write plain data to an indented JSON file. Without `allow_nan`, raises ValueError for NaN and infinities."""
    text = json.dumps(data, indent=1, ensure_ascii=False, sort_keys=sort_keys, allow_nan=allow_nan)
    write_text_atomically(path, text + "\n")


def write_text_atomically(path: Path, text: str) -> None:
    """Write a UTF-8 file with `write_atomically`. A file that has this text already is left as it is."""
    write_bytes_atomically(path, text.encode("utf-8"))


def write_bytes_atomically(path: Path, data: bytes) -> None:
    """Write a file with `write_atomically`. A file that has these contents already is left as it is."""
    with suppress(OSError):
        if path.read_bytes() == data:
            return
    with write_atomically(path) as temporary:
        temporary.write_bytes(data)


def append_line(path: Path, line: str) -> None:
    """Append a line of UTF-8 text to a file. If a killed process left the last line unfinished, that line is ended first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a+b") as file:
        line_end = b""
        if file.seek(0, os.SEEK_END):
            file.seek(-1, os.SEEK_END)
            line_end = b"" if file.read(1) == b"\n" else b"\n"
        file.write(line_end + line.encode("utf-8") + b"\n")


def check_can_be_written(folder: Path) -> None:
    """Raise InputError if a folder cannot be created or written to. Nothing is created."""
    there = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
    if not there.is_dir():
        raise InputError(folder, "expected a folder: this is a file" if there == folder else f"{there} is a file, not a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(folder, "cannot be written to")


def remove_leftovers(folder: Path) -> None:
    """Remove the drafts that killed runs left in `folder` and below. The caller must hold the lock of the workspace."""
    for path in Path(folder).rglob(_REPLACED.format(name="*")):
        _restore(path)
        _remove(path)
    for path in Path(folder).rglob(_TEMPORARY.format(name="*")):
        _remove(path)


def restore_replaced(folder: Path) -> None:
    """Bring back the folders in `folder` that killed runs were replacing. The caller must hold the lock of `folder`."""
    for path in Path(folder).glob(_REPLACED.format(name="*")):
        _restore(path)


def _restore(replaced: Path) -> None:
    """Give a replaced folder its name again, unless something has taken its place."""
    start, end = _REPLACED.split("{name}")
    path = replaced.with_name(replaced.name.removeprefix(start).removesuffix(end))
    if os.path.lexists(replaced) and not os.path.lexists(path):
        replaced.rename(path)


def _check_removable(path: Path) -> None:
    """Raise PermissionError if a folder could not be removed as a whole, before anything is written."""
    if path.is_dir() and not path.is_symlink():
        for place, _, _ in os.walk(path):
            if not os.access(place, os.W_OK | os.X_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), place)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Flush a file, or all files of a folder, to the disk."""
    if not path.is_dir():
        _sync_file(path)
        return
    with ThreadPoolExecutor(_SYNCED_AT_ONCE) as pool:
        list(pool.map(_sync_file, (file for file in path.rglob("*") if file.is_file() and not file.is_symlink())))


def _sync_file(path: Path) -> None:
    if os.name == "posix":
        _flush(path, os.O_RDONLY)  # kept files of the user may be read-only
    else:
        _flush(path, os.O_RDWR)


def _sync_folder(path: Path) -> None:
    if os.name == "posix":
        _flush(path, os.O_RDONLY)


def _flush(path: Path, mode: int) -> None:
    handle = os.open(path, mode)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
