"""Finding shapes below a folder, whatever the layout, by what the folders contain."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.io.readers.dsg_net_reader import shape_id
from kinmo.io.readers.field import clean_text
from kinmo.io.readers.glb_reader import ENDING as GLB_ENDING
from kinmo.io.readers.partnet_annotation import MESH_FOLDERS
from kinmo.io.readers.partnet_reader import HIERARCHY_FILES
from kinmo.io.readers.untrusted_files import read_beginning

WORKSPACE = "prepared/index.jsonl"
"""What a folder has that is a workspace of kinmo: its pseudo labels are nobody's shapes."""
_PEEK = 1 << 16
_DEEPEST_FOLDER = 64


class Layout(str, Enum):
    """How a dataset lays out a shape."""

    PARTNET_MOBILITY = "partnet_mobility"
    PARTNET = "partnet"
    DSG_NET = "dsg_net"
    GLB = "glb"


@dataclass(frozen=True)
class Found:
    """A shape that a reader may be tried on: a folder, the tree JSON of DSG_NET, or the file of GLB."""

    path: Path
    layout: Layout
    id: str


def discover(
    root: Path, *, skip: tuple[Path, ...] = (), report: Callable[[InputError], None] = lambda error: None
) -> Iterator[Found]:
    """All shapes at or below `root`, those in a folder itself before those in its subfolders, by name.

    Hidden files and folders, and workspaces, are passed over. Links to folders are not followed; links to folders and shapes
    outside of `root`, and folders that cannot be listed, are told to `report`. `skip` are folders to keep out of. `root` may
    also be the file of one shape, a DSG-Net tree or a GLB. Raises InputError if it is neither that nor a folder.
    """
    root = Path(root)
    if root.is_file() and (found := _file_of_shape(root)) is not None:
        yield found
        return
    if not root.is_dir():
        what = (
            f"is a file, expected a folder of shapes, or a shape as {GLB_ENDING}: unpack archives first"
            if root.exists()
            else "missing, expected a folder of shapes"
        )
        raise InputError(root, what)
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
        names = {entry.name for entry in entries}
        layout = _layout(folder, names)
        if layout is not None:
            yield Found(folder, layout, clean_text(Path(os.path.realpath(folder)).name))
            continue
        subfolders = []
        for entry in entries:
            if entry.is_symlink():
                _judge_link(Path(entry.path), home, report)
            elif entry.is_dir(follow_symlinks=False):
                subfolders.append(Path(entry.path))
            elif (found := _file_of_shape(Path(entry.path))) is not None:
                yield found
        if depth >= _DEEPEST_FOLDER and subfolders:
            report(InputError(folder, f"folders nested deeper than {_DEEPEST_FOLDER} levels"))
            continue
        pending += [(path, depth + 1) for path in reversed(subfolders)]


def _file_of_shape(path: Path) -> Found | None:
    """The shape that is in one file, None if it is none."""
    if path.suffix == ".json" and _is_tree(path, path.parent):
        return Found(path, Layout.DSG_NET, shape_id(path))
    name = clean_text(path.stem)
    return Found(path, Layout.GLB, name) if path.suffix.lower() == GLB_ENDING and name.strip(".") else None


def _layout(folder: Path, names: set[str]) -> Layout | None:
    """The layout of a shape's own folder, None if the folder is not one."""
    if "mobility_v2.json" in names:
        return Layout.PARTNET_MOBILITY
    if names & {*HIERARCHY_FILES} and (names & {*MESH_FOLDERS} or _is_annotation(folder, names)):
        return Layout.PARTNET
    return None


def _is_annotation(folder: Path, names: set[str]) -> bool:
    """Whether a result.json without meshes beside it looks like PartNet's, and so deserves a complaint."""
    text = _beginning(folder / next(name for name in HIERARCHY_FILES if name in names), folder)
    return bool(re.match(rb"\s*\[\s*\{", text)) and b'"name"' in text and b'"id"' in text


def _is_tree(path: Path, folder: Path) -> bool:
    """Whether a JSON file is one of StructureNet's trees. In a folder `*_hier` all are meant to be."""
    if Path(os.path.realpath(folder)).name.endswith("_hier"):
        return True
    text = _beginning(path, folder)
    has_fields = b'"label"' in text and b'"id"' in text and (b'"children"' in text or b'"box"' in text)
    return has_fields and bool(re.match(rb"\s*\{", text))


def _beginning(path: Path, folder: Path) -> bytes:
    try:
        return read_beginning(path, folder, _PEEK)
    except InputError:
        return b""


def _judge_link(path: Path, home: str, report: Callable[[InputError], None]) -> None:
    """A link to what is inside `home` is found by its own path; one that leads elsewhere would be lost in silence."""
    try:
        target = os.path.realpath(path, strict=True)
    except (OSError, ValueError):
        return
    if target == home or target.startswith(home + os.sep):
        return
    if Path(target).is_dir() or _file_of_shape(path) is not None:
        report(InputError(path, "a link that leads out of the folder: not followed, name its target instead"))
