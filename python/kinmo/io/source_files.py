"""The files that a shape is read from: their state, to notice changes, and their contents, to recognise copies."""

from __future__ import annotations

import os
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import printable_path
from kinmo.io.discover import ShapeSource
from kinmo.io.readers import READERS

_BLOCK = 1 << 20
"""Bytes that are hashed at a time."""


def fingerprint(source: ShapeSource) -> list[list[str | int]]:
    """Name, size (bytes) and time of change (nanoseconds) of each file of a shape. A link has a second row for its target.

    Raises InputError if a file cannot be accessed.
    """
    rows: list[list[str | int]] = []
    try:
        for name, path in _files(source):
            both = [path.lstat(), *([path.stat()] if path.is_symlink() and path.exists() else [])]
            rows += [[name, status.st_size, status.st_mtime_ns] for status in both]
    except OSError as error:
        raise _unreadable(error, source) from None
    return rows


def content_digest(source: ShapeSource) -> str:
    """Hash of the names and contents of the files of a shape, in hexadecimal. Raises InputError for unreadable files."""
    total = blake2b(digest_size=16)
    try:
        for name, path in _files(source):
            total.update(f"{name}\0".encode())
            if path.is_file():
                with path.open("rb") as file:
                    while block := file.read(_BLOCK):
                        total.update(block)
            total.update(b"\0")
    except OSError as error:
        raise _unreadable(error, source) from None
    return total.hexdigest()


def have_same_contents(one: ShapeSource, other: ShapeSource) -> bool:
    """True if the files of two shapes have the same contents. False if those of one cannot be read."""
    try:
        return content_digest(one) == content_digest(other)
    except InputError:
        return False


def _unreadable(error: OSError, source: ShapeSource) -> InputError:
    return InputError(printable_path(error.filename or source.path), f"cannot be read ({error.strerror})")


def _files(source: ShapeSource) -> Iterator[tuple[str, Path]]:
    """Name relative to the folder of the shape, and path, of every file, in a fixed order."""
    base, places = READERS[source.layout].source_files(source.path)
    for place in places:
        for path in _meshes(place) if place.is_dir() else [place] * os.path.lexists(place):
            yield printable_path(os.path.relpath(path.absolute(), base)), path


def _meshes(folder: Path) -> list[Path]:
    with os.scandir(folder) as entries:
        return sorted(Path(entry.path) for entry in entries if entry.name.lower().endswith(".obj"))
