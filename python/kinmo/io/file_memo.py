"""A cache for values read from files, valid as long as a file does not change."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TypeVar

_MIN_AGE = 2_000_000_000
"""Age of a file in nanoseconds from which its value is cached: more than the clock resolution of any file system."""

Value = TypeVar("Value")


def kept_while_unchanged(read: Callable[[Path], Value]) -> Callable[[Path], Value]:
    """Decorator that caches what a function reads from a file until the file changes. Callers must not modify the value.

    The value of a file that changed less than two seconds ago is not cached. Such a file could change again without a new time
    stamp, because the clocks of file systems are coarse.
    """
    known: dict[Path, tuple[tuple[int, ...], Value]] = {}

    @wraps(read)
    def cached_read(path: Path) -> Value:
        try:
            status = path.stat()
        except OSError:
            return read(path)  # raises its own error
        stamp = status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns
        kept = known.get(path)
        if kept is not None and kept[0] == stamp:
            return kept[1]
        is_old_enough = time.time_ns() - status.st_ctime_ns > _MIN_AGE
        value = read(path)
        if is_old_enough:
            known[path] = stamp, value
        return value

    return cached_read
