"""A lock that keeps two processes from writing into one folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kinmo.core.errors import InputError, KinmoError


class InUse(KinmoError):
    """Another kinmo process is writing into the folder."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keep other kinmo processes from writing into a folder while the block runs. The folder is created if necessary.

    The operating system releases the lock of a process that dies. Raises InUse if another process holds it, and InputError if
    the folder cannot be created or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        if folder.exists() and not folder.is_dir():
            raise InputError(folder, "is a file: name a folder") from None
        raise InputError(folder, f"cannot be written to ({error.strerror})") from None
    try:
        if not _acquire(handle):
            holder = os.pread(handle, 32, 0).decode("ascii", "replace").strip() or "unknown"
            raise InUse(folder, f"another kinmo (process {holder}) is writing here: wait for it, or name another folder")
        os.ftruncate(handle, 0)
        os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)
        yield
        os.ftruncate(handle, 0)
    finally:
        os.close(handle)


def _acquire(handle: int) -> bool:
    """Lock an open file. False if another process holds the lock. Always True without fcntl (Windows)."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
