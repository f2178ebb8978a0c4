"""Safe reading of files from unknown sources: regular files of limited size inside their own folder.

The argument `folder` is the folder that a path must be in, as it is written. Links in the file system are followed wherever
they lead. All functions raise InputError for a path that leads out of the folder, and for a file that is missing, too large, or
a pipe, socket or device. They never wait for those.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterable
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import clean_text
from kinmo.io.readers.json_field import JsonField

MAX_JSON_BYTES = 32 << 20
MAX_MESH_BYTES = 128 << 20
MAX_SCENE_BYTES = 1 << 30
_MISSING = "missing"
PEEK_BYTES = 1 << 16
"""Bytes at the beginning of a file by which its format is recognised."""
_LFS_POINTER = b"version https://git-lfs.github.com/spec/v1"
_OPEN_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def plain_path(path: Path) -> Path:
    """The absolute path without steps such as `..`."""
    return Path(os.path.normpath(path.absolute()))


def inside(path: Path, folder: Path) -> Path:
    """The absolute path without steps such as `..`. Raises InputError if it leads out of the folder."""
    place, home = plain_path(path), plain_path(folder)
    if place != home and home not in place.parents:
        raise InputError(path, f"leads out of the folder {home.name}: expected a path inside it")
    return place


def those_inside(paths: Iterable[Path], folder: Path) -> list[Path]:
    """The paths that do not lead out of the folder, as they are written."""
    home = plain_path(folder)
    return [path for path in paths if plain_path(path).is_relative_to(home)]


def read_bytes(path: Path, folder: Path, max_bytes: int) -> bytes:
    """All bytes of a regular file of at most `max_bytes` bytes. Raises InputError for a pointer of Git LFS."""
    data = read_beginning(path, folder, max_bytes + 1)
    if len(data) > max_bytes:
        raise InputError(path, f"larger than {max_bytes >> 20} MiB")
    check_no_pointer(data, path)
    return data


def is_pointer(data: bytes) -> bool:
    """True for the beginning of a small file that Git LFS leaves in place of one that is not downloaded."""
    return data.startswith(_LFS_POINTER)


def check_no_pointer(data: bytes, path: Path) -> None:
    """Raise InputError if the beginning of the file `path` is that of a pointer of Git LFS."""
    if is_pointer(data):
        raise InputError(path, "a Git LFS pointer, not the file itself: run `git lfs pull` in its repository")


def read_beginning(path: Path, folder: Path, count: int) -> bytes:
    """The first `count` bytes of a regular file."""
    try:
        handle = os.open(inside(path, folder), _OPEN_FLAGS)
        try:
            if not stat.S_ISREG(os.fstat(handle).st_mode):
                raise InputError(path, "not a regular file")
            with os.fdopen(handle, "rb", closefd=False) as file:
                return file.read(count)
        finally:
            os.close(handle)
    except InputError:
        raise
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None


def peek(path: Path, folder: Path) -> bytes:
    """The first 64 KiB of a regular file, to recognise its format. Empty if the file cannot be read."""
    try:
        return read_beginning(path, folder, PEEK_BYTES)
    except InputError:
        return b""


def named_by(where: Path, field: str, name: str, problem: InputError) -> InputError:
    """The problem with a file that the field of another file names, as a problem of that field.

    Args:
        where: the file that has the field.
        field: the field.
        name: what the field says.
        problem: why the file of this name cannot be read.
    """
    if problem.problem == _MISSING:
        return InputError(where, f"{clean_text(name)} is missing: put it there, or correct the path", field)
    return InputError(where, f"{clean_text(name)}: {problem.problem}", field)


def read_json(path: Path, folder: Path) -> JsonField:
    """The value of a UTF-8 JSON file."""
    return parse_json(read_bytes(path, folder, MAX_JSON_BYTES), path)


def parse_json(raw: bytes, where: Path) -> JsonField:
    """The value of UTF-8 JSON text from the file `where`. Raises InputError for anything else."""
    try:
        return JsonField(where, json.loads(raw.decode("utf-8-sig")))
    except UnicodeDecodeError as error:
        raise InputError(where, f"not UTF-8 at byte {error.start}") from None
    except RecursionError:
        raise InputError(where, "nested too deeply") from None
    except ValueError as error:
        raise InputError(where, "empty" if not raw.strip() else f"not JSON ({error})") from None


def _unreadable(path: Path, error: OSError | ValueError) -> InputError:
    if isinstance(error, FileNotFoundError):
        return InputError(path, _MISSING)
    return InputError(path, f"cannot be read ({getattr(error, 'strerror', None) or error})")
