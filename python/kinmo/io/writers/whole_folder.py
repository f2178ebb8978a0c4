"""Folders that are either whole or absent."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from kinmo.io.atomic_files import write_atomically


@contextmanager
def whole_folder(target: Path) -> Iterator[Path]:
    """A folder to write into that takes the place of `target` when the block ends, and vanishes if it fails.

    What was at `target` before is replaced as a whole. What a killed process left is cleared away by the next one that writes
    `target`.
    """
    with write_atomically(target) as draft:
        draft.mkdir()
        yield draft
