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
from kinmo.io.readers import DSG_NET, READERS
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import PEEK_BYTES, check_no_pointer, read_beginning

WORKSPACE = "prepared/index.jsonl"
"""A file by which kinmo's own workspaces are recognised. The pseudo labels in them are no input shapes."""
_MAX_DEPTH = 64
"""Deepest folder that is searched."""
_MESHES_OF_OTHERS = ("_obj", "_objs")
"""Endings of folders with the meshes of shapes whose trees are elsewhere (DSG-Net)."""
_PREDICTION = "joints.json"
"""The file by which results of kinmo are recognised. The exports beside it are no input shapes."""


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

    def read(self, facts: StatedFacts = NO_FACTS) -> Shape:
        """The shape, in the frame and the length unit of its file, with the facts that the user states.

        Raises InputError if the files cannot be used, or the facts do not fit.
        """
        if self.path.is_file() and not self.path.stat().st_size:
            raise InputError(self.path, "is empty: write it again")
        reader = READERS[self.layout]
        if reader.read_stated is not None:
            return reader.read_stated(self.path, facts)
        if facts.labels is not None:
            raise InputError("--labels", f"does not apply to {self.path}: its files say what its parts are")
        return facts.of(reader.read(self.path))


def discover(
    root: Path, *, skip: tuple[Path, ...] = (), report: Callable[[InputError], None] = lambda error: None
) -> Iterator[ShapeSource]:
    """Find all shapes at or below a folder, in the order of their names, those of a folder before those of its subfolders.

    Hidden files and folders, and kinmo's workspaces, are skipped. Links are followed, unless they lead to what is found at its
    own place below `root`. A folder that several links lead to is searched once.

    Args:
        root: the folder to search, the folder of one shape, or the file of one shape.
        skip: folders to skip.
        report: receives a note about each folder that cannot be searched.

    Raises:
        InputError: `root` does not exist, or is a file of an unknown format.
    """
    root = Path(root)
    if root.is_file():
        if (found := _shape_in_file(root)) is not None:
            yield found
            return
        check_no_pointer(read_beginning(root, root.parent, PEEK_BYTES), root)
    if not root.is_dir():
        endings = ", ".join(ending for reader in READERS.values() for ending in reader.endings)
        if not root.exists():
            raise InputError(root, "no such file or folder")
        if root.suffix.lower() == ".ply":
            raise InputError(root, "expected faces: a file of points alone is a scan, which is predicted with its category")
        remedy = "convert it to one of these, with Blender for example"
        raise InputError(root, f"expected a folder of shapes, or a shape as {endings}: {remedy}")
    seen = {os.path.realpath(path) for path in skip}
    home = os.path.realpath(root)
    pending = [(root, 0, True)]
    while pending:
        folder, depth, with_meshes = pending.pop()
        real = os.path.realpath(folder)
        if real in seen:
            continue
        seen.add(real)
        if not os.access(folder, os.R_OK | os.X_OK):
            report(InputError(folder, "cannot be listed: allow reading it (chmod u+rx)"))
            continue
        if (folder / WORKSPACE).is_file():
            continue
        try:
            listed = [entry for entry in os.scandir(folder) if not entry.name.startswith(".")]
        except OSError as error:
            report(InputError(folder, f"cannot be listed ({error.strerror})"))
            continue
        entries = sorted(listed, key=lambda entry: entry.name)
        names = {entry.name for entry in entries}
        with_meshes = with_meshes and not _is_robot_folder(folder, names)
        whole = _shape_in_folder(folder, names, with_meshes)
        if whole is not None:
            yield whole
            if not READERS[whole.layout].is_bare_mesh:
                continue
        is_result = _PREDICTION in names
        subfolders = []
        for entry in entries:
            if entry.is_symlink() and not _is_followed(entry, home):
                continue
            if entry.is_dir():
                subfolders.append((Path(entry.path), with_meshes and not _has_meshes_of_others(folder, entry.name, names)))
            elif whole is None and not is_result and (found := _shape_in_file(Path(entry.path), with_meshes)) is not None:
                yield found
        if depth >= _MAX_DEPTH and subfolders:
            report(InputError(folder, f"folders nested deeper than {_MAX_DEPTH} levels"))
            continue
        pending += [(path, depth + 1, has_meshes) for path, has_meshes in reversed(subfolders)]


def _is_robot_folder(folder: Path, names: set[str]) -> bool:
    """True if a folder has a robot file or a prediction. The meshes in and below it belong to that."""
    robots = [reader for reader in READERS.values() if reader.is_robot]
    return _PREDICTION in names or any(reader.id_of_file(folder / name) is not None for name in names for reader in robots)


def _has_meshes_of_others(above: Path, name: str, names: set[str]) -> bool:
    """True if the meshes of the folder `name` belong to a tree file of DSG-Net. `names` are its neighbours in `above`."""
    tree = f"{name}.json"
    return name.endswith(_MESHES_OF_OTHERS) or (tree in names and READERS[DSG_NET].id_of_file(above / tree) is not None)


def _shape_in_file(path: Path, with_meshes: bool = True) -> ShapeSource | None:
    """The shape that one file holds. None if no reader recognises it. Bare meshes count only `with_meshes`."""
    readers = (each for each in READERS.values() if with_meshes or not each.is_bare_mesh)
    ids = ((reader.layout, reader.id_of_file(path)) for reader in readers)
    return next((ShapeSource(path, layout, shape_id) for layout, shape_id in ids if shape_id is not None), None)


def _shape_in_folder(folder: Path, names: set[str], with_meshes: bool) -> ShapeSource | None:
    """The shape that a whole folder holds. None if no reader recognises it. Bare meshes count only `with_meshes`."""
    for reader in READERS.values():
        if (with_meshes or not reader.is_bare_mesh) and reader.is_shape_folder(folder, names):
            return ShapeSource(folder, reader.layout, clean_text(Path(os.path.realpath(folder)).name))
    return None


def _is_followed(link: os.DirEntry[str], home: str) -> bool:
    """True for a link to what is not found at its own place below `home`: it is outside, hidden, or has another ending."""
    try:
        target = Path(os.path.realpath(link.path, strict=True))
    except (OSError, ValueError):
        return False
    if not target.is_relative_to(home):
        return True
    is_hidden = any(name.startswith(".") for name in target.relative_to(home).parts)
    return is_hidden or (target.is_file() and target.suffix != Path(link.name).suffix)
