"""Which files a shape is read from, to notice when they change and to compare copies."""

from __future__ import annotations

import os
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.io.readers.discover import Found, Layout
from kinmo.io.readers.dsg_net_reader import geometry_places
from kinmo.io.readers.partnet_annotation import MESH_FOLDERS

_FILES = ("mobility_v2.json", "result.json", "result_after_merging.json", "meta.json")


def fingerprint(found: Found) -> list[list[str | int]]:
    """Names, sizes in bytes and times of change (ns) of the files that a shape is read from, as plain data.

    Of a link those of what it leads to as well.
    Raises InputError for files that cannot be looked at.
    """
    rows: list[list[str | int]] = []
    try:
        for name, path in _files(found):
            both = [path.lstat(), *([path.stat()] if path.is_symlink() and path.exists() else [])]
            rows += [[name, status.st_size, status.st_mtime_ns] for status in both]
    except OSError as error:
        raise _unreadable(error, found) from None
    return rows


def content_digest(found: Found) -> str:
    """A hash of the contents of the files that a shape is read from: the same for true copies.

    Raises InputError for files that cannot be read.
    """
    total = blake2b(digest_size=16)
    try:
        for name, path in _files(found):
            total.update(f"{name}\0".encode())
            if path.is_file():
                with path.open("rb") as file:
                    while block := file.read(1 << 20):
                        total.update(block)
            total.update(b"\0")
    except OSError as error:
        raise _unreadable(error, found) from None
    return total.hexdigest()


def are_alike(one: Found, other: Found) -> bool:
    """Whether two copies have the same contents, as far as both can be read."""
    try:
        return content_digest(one) == content_digest(other)
    except InputError:
        return False


def _unreadable(error: OSError, found: Found) -> InputError:
    return InputError(shown(error.filename or found.path), f"cannot be read ({error.strerror})")


def shown(path: Path | str) -> str:
    """A path as text that can be printed and stored, whatever bytes it is made of."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def _files(found: Found) -> Iterator[tuple[str, Path]]:
    """Names relative to the shape's folder, and paths, in a fixed order."""
    if found.layout is Layout.DSG_NET:
        places = [found.path, *geometry_places(found.path)]
        base = found.path.absolute().parent.parent
    elif found.layout is Layout.GLB:
        places = [found.path]
        base = found.path.absolute().parent
    else:
        places = [found.path / name for name in (*_FILES, *MESH_FOLDERS)]
        base = found.path.absolute()
    for place in places:
        for path in _meshes(place) if place.is_dir() else [place] * os.path.lexists(place):
            yield shown(os.path.relpath(path.absolute(), base)), path


def _meshes(folder: Path) -> list[Path]:
    with os.scandir(folder) as entries:
        return sorted(Path(entry.path) for entry in entries if entry.name.lower().endswith(".obj"))
