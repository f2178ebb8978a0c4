"""A lock that keeps two processes from writing into one folder."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kinmo.core.errors import InputError, KinmoError


class InUse(KinmoError):
    """Another process writes into a folder: nothing can be done there now."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Makes `folder`, if need be, and keeps other kinmo processes from writing there.

    The system frees the lock of a process that dies, however it dies. Raises InUse if another process holds the lock, and
    InputError if the folder cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise InputError(folder, f"cannot be written to ({error.strerror})") from None
    try:
        if not _lock(handle):
            holder = os.pread(handle, 32, 0).decode("ascii", "replace").strip() or "unknown"
            raise InUse(folder, f"another kinmo (process {holder}) is writing here: wait for it, or name another folder")
        os.ftruncate(handle, 0)
        os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)
        yield
        os.ftruncate(handle, 0)
    finally:
        os.close(handle)


def _lock(handle: int) -> bool:
    """Whether the lock on an open file was free. Without fcntl (Windows) there are no locks."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True
