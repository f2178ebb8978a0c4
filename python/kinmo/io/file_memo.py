"""Values read from files, kept for as long as the files do not change."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TypeVar

_SETTLED = 2_000_000_000
"""Nanoseconds, longer than a tick of the clock of any file system."""

Value = TypeVar("Value")


def kept_while_unchanged(read: Callable[[Path], Value]) -> Callable[[Path], Value]:
    """Keeps what `read` gave of a file for as long as the file stays as it is. Nobody may change what was given.

    Nothing is kept of a file that has just changed: it could change again and look the same, since clocks of file systems tick
    slowly.
    """
    known: dict[Path, tuple[tuple[int, ...], Value]] = {}

    @wraps(read)
    def reading(path: Path) -> Value:
        try:
            found = path.stat()
        except OSError:
            return read(path)  # which tells it in its own words
        stamp = found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
        kept = known.get(path)
        if kept is not None and kept[0] == stamp:
            return kept[1]
        is_settled = time.time_ns() - found.st_ctime_ns > _SETTLED
        value = read(path)
        if is_settled:
            known[path] = stamp, value
        return value

    return reading
