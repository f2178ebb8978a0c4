"""Safe reading of files from unknown sources: regular files of limited size inside their own folder.

The argument `folder` is the folder that a file must be in, with links followed. All functions raise InputError for a file that
leads out of it, is missing, too large, or a pipe, socket or device. They never wait for those.
"""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.io.readers.json_field import JsonField

MAX_JSON_BYTES = 32 << 20
MAX_MESH_BYTES = 128 << 20
MAX_SCENE_BYTES = 1 << 30
_PEEK_BYTES = 1 << 16
_OPEN_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def inside(path: Path, folder: Path) -> Path:
    """The path without links. Raises InputError if it leads out of the folder, does not exist, or is a cycle of links."""
    try:
        real = Path(os.path.realpath(path, strict=True))
        home = Path(os.path.realpath(folder))
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    if real != home and home not in real.parents:
        raise InputError(path, f"leads out of the folder {folder.name}")
    return real


def read_bytes(path: Path, folder: Path, max_bytes: int) -> bytes:
    """All bytes of a regular file of at most `max_bytes` bytes."""
    data = read_beginning(path, folder, max_bytes + 1)
    if len(data) > max_bytes:
        raise InputError(path, f"larger than {max_bytes >> 20} MiB")
    return data


def read_beginning(path: Path, folder: Path, count: int) -> bytes:
    """The first `count` bytes of a regular file."""
    try:
        handle = _open(path, folder)
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
        return read_beginning(path, folder, _PEEK_BYTES)
    except InputError:
        return b""


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


def _open(path: Path, folder: Path) -> int:
    try:
        return os.open(path, _OPEN_FLAGS | getattr(os, "O_NOFOLLOW", 0))
    except OSError as error:
        if error.errno != errno.ELOOP:
            raise
        return os.open(inside(path, folder), _OPEN_FLAGS)


def _unreadable(path: Path, error: OSError | ValueError) -> InputError:
    if isinstance(error, FileNotFoundError):
        return InputError(path, "missing")
    return InputError(path, f"cannot be read ({getattr(error, 'strerror', None) or error})")
