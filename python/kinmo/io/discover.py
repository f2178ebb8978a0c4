"""Search a folder for shapes of any input format, recognised by their contents."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from kinmo.core.errors import InputError
from kinmo.core.shape import Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers import READERS

WORKSPACE = "prepared/index.jsonl"
"""A file by which kinmo's own workspaces are recognised. The pseudo labels in them are no input shapes."""
_MAX_DEPTH = 64
"""Deepest folder that is searched."""


class _Entry(Protocol):
    """A record of a shape that was read."""

    @property
    def source(self) -> str: ...
    @property
    def layout(self) -> str: ...
    @property
    def id(self) -> str: ...


@dataclass(frozen=True)
class ShapeSource:
    """A shape that can be read.

    Attributes:
        path: the folder of the shape, or its file if the format has one file per shape.
        layout: name of the input format, a key of `kinmo.io.readers.READERS`.
        id: the id that the shape has when it is read.
    """

    path: Path
    layout: str
    id: str

    @classmethod
    def of(cls, entry: _Entry) -> ShapeSource:
        """The source that a prepared shape was read from."""
        return cls(Path(entry.source), entry.layout, entry.id)

    def read(self) -> Shape:
        """The shape, in the frame and the length unit of its file. Raises InputError if the files cannot be used."""
        return READERS[self.layout].read(self.path)


def discover(
    root: Path, *, skip: tuple[Path, ...] = (), report: Callable[[InputError], None] = lambda error: None
) -> Iterator[ShapeSource]:
    """Find all shapes at or below a folder, in the order of their names, those of a folder before those of its subfolders.

    Hidden files and folders, and kinmo's workspaces, are skipped. Links to folders are not followed.

    Args:
        root: the folder to search, the folder of one shape, or the file of one shape.
        skip: folders to skip.
        report: receives a note about each link that leads out of `root` and each folder that cannot be listed.

    Raises:
        InputError: `root` does not exist, or is a file of an unknown format.
    """
    root = Path(root)
    if root.is_file() and (found := _shape_in_file(root)) is not None:
        yield found
        return
    if not root.is_dir():
        endings = ", ".join(reader.ending for reader in READERS.values() if reader.ending)
        if not root.exists():
            raise InputError(root, "no such file or folder")
        raise InputError(root, f"expected a folder of shapes, or a shape as {endings}: export it with one node per moving part")
    skipped = {os.path.realpath(path) for path in skip}
    home = os.path.realpath(root)
    pending = [(root, 0)]
    while pending:
        folder, depth = pending.pop()
        if (folder / WORKSPACE).is_file() or (skipped and os.path.realpath(folder) in skipped):
            continue
        try:
            listed = [entry for entry in os.scandir(folder) if not entry.name.startswith(".")]
        except OSError as error:
            report(InputError(folder, f"cannot be listed ({error.strerror})"))
            continue
        entries = sorted(listed, key=lambda entry: entry.name)
        found = _shape_in_folder(folder, {entry.name for entry in entries})
        if found is not None:
            yield found
            continue
        subfolders = []
        for entry in entries:
            if entry.is_symlink():
                _check_link(Path(entry.path), home, report)
            elif entry.is_dir(follow_symlinks=False):
                subfolders.append(Path(entry.path))
            elif (found := _shape_in_file(Path(entry.path))) is not None:
                yield found
        if depth >= _MAX_DEPTH and subfolders:
            report(InputError(folder, f"folders nested deeper than {_MAX_DEPTH} levels"))
            continue
        pending += [(path, depth + 1) for path in reversed(subfolders)]


def _shape_in_file(path: Path) -> ShapeSource | None:
    """The shape that one file holds. None if no reader recognises it."""
    ids = ((reader.layout, reader.id_of_file(path)) for reader in READERS.values())
    return next((ShapeSource(path, layout, shape_id) for layout, shape_id in ids if shape_id is not None), None)


def _shape_in_folder(folder: Path, names: set[str]) -> ShapeSource | None:
    """The shape that a whole folder holds. None if no reader recognises it."""
    for reader in READERS.values():
        if reader.is_shape_folder(folder, names):
            return ShapeSource(folder, reader.layout, clean_text(Path(os.path.realpath(folder)).name))
    return None


def _check_link(path: Path, home: str, report: Callable[[InputError], None]) -> None:
    """Report a link to a shape or folder outside `home`. What a link inside `home` leads to is found by its own path."""
    try:
        target = os.path.realpath(path, strict=True)
    except (OSError, ValueError):
        return
    if target == home or target.startswith(home + os.sep):
        return
    if Path(target).is_dir() or _shape_in_file(path) is not None:
        report(InputError(path, "a link that leads out of the folder: not followed, name its target instead"))
