"""Reading files that nobody vouches for: bounded, regular, and inside the folder they belong to."""

from __future__ import annotations

import errno
import json
import os
import stat
from pathlib import Path

from kinmo.core.errors import InputError

LARGEST_JSON = 32 << 20
LARGEST_MESH = 128 << 20
_OPEN_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def inside(path: Path, folder: Path) -> Path:
    """`path` with its links followed.

    Raises InputError if that leads out of `folder`, nowhere, or round in a circle.
    """
    try:
        real = Path(os.path.realpath(path, strict=True))
        home = Path(os.path.realpath(folder))
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    if real != home and home not in real.parents:
        raise InputError(path, f"leads out of the folder {folder.name}")
    return real


def read_bytes(path: Path, folder: Path, largest: int) -> bytes:
    """Contents of a regular file in `folder`.

    Raises InputError for one that is larger than `largest` bytes, and for pipes, sockets and devices, without waiting for them.
    """
    data = read_beginning(path, folder, largest + 1)
    if len(data) > largest:
        raise InputError(path, f"larger than {largest >> 20} MiB")
    return data


def read_beginning(path: Path, folder: Path, count: int) -> bytes:
    """The first `count` bytes of a regular file in `folder`."""
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


def read_json(path: Path, folder: Path) -> object:
    """The value of a UTF-8 JSON file in `folder`."""
    raw = read_bytes(path, folder, LARGEST_JSON)
    try:
        value: object = json.loads(raw.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(path, f"not UTF-8 at byte {error.start}") from None
    except RecursionError:
        raise InputError(path, "nested too deeply") from None
    except ValueError as error:
        raise InputError(path, "empty" if not raw.strip() else f"not JSON ({error})") from None
    return value


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
