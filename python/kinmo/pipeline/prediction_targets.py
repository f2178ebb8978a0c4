"""Shapes that the stage `predict` is asked for, and a folder for the result of each."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.names import short_name
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import PARTNET_MOBILITY, READERS
from kinmo.io.readers.ply_reader import PLY
from kinmo.io.readers.untrusted_files import PEEK_BYTES, check_no_pointer, plain_path, read_beginning
from kinmo.pipeline.export_results import find_results
from kinmo.scans.files.scan_formats import SCAN_SUFFIXES


def prediction_targets(sources: Sequence[Path], out: Path) -> tuple[list[tuple[ShapeSource, Path]], list[str]]:
    """Find every shape, and name a folder of its own for it, after its id.

    Shapes with the same id are named after their paths. The only PartNet-Mobility shape among them keeps the id, because other
    tools look for its URDF under it. Long names are cut. A shape that several sources hold counts once.

    Args:
        sources: files and folders to search.
        out: folder that the folders of the results are in. It is not searched.

    Returns:
        The shapes with their folders, and a line for each source or folder that cannot be used.

    Raises:
        InputError: the only source has neither shapes nor such folders.
    """
    problems: list[str] = []
    found: dict[Path, ShapeSource] = {}
    places: list[Path] = []
    for source in sources:
        try:
            places.append(plain_path(source if source.is_dir() else source.parent))
            shapes, lines = _search(source, out)
        except (InputError, PermissionError) as error:
            problem = InputError(source, f"cannot be read ({error.strerror})") if isinstance(error, OSError) else error
            if len(sources) == 1:
                raise problem from None
            shapes, lines = [], [str(problem)]
        problems += lines
        for shape in shapes:
            found.setdefault(plain_path(shape.path), shape)
    above = os.path.commonpath(places) if places else ""
    names = _folder_names(list(found.values()), list(found), Path(above))
    return [(shape, out / name) for shape, name in zip(found.values(), names, strict=True)], problems


def _search(source: Path, out: Path) -> tuple[list[ShapeSource], list[str]]:
    """The shapes at or below a path, and a line for each folder that cannot be searched."""
    problems: list[InputError] = []
    _check_no_scan(source)
    shapes = list(discover(source, skip=(out,), report=problems.append))
    if not shapes and not problems:
        if out.resolve() == source.resolve() and next(discover(source), None) is not None:
            raise InputError("--out", "is the folder with the shapes: name another")
        if next(find_results(source), None) is not None:
            raise InputError(source, "has results of kinmo predict, but no other shape: kinmo export writes results again")
        scans = sum(path.suffix.lower() in SCAN_SUFFIXES for path in source.rglob("*"))
        hint = f". Found {counted(scans, 'scan')}: for scans, add --category" if scans else ""
        raise InputError(source, f"expected at least one shape at or below it (docs/reference/formats.md){hint}")
    return shapes, list(map(str, problems))


def _check_no_scan(source: Path) -> None:
    """Raise InputError for a file that may hold a scan and no shape, and for one that cannot be read."""
    if source.suffix.lower() not in SCAN_SUFFIXES or not source.is_file():
        return
    begin = read_beginning(source, source.parent, PEEK_BYTES)
    check_no_pointer(begin, source)
    if not begin:
        raise InputError(source, "is empty: write it again")
    if READERS[PLY].id_of_file(source) is None:
        raise InputError(source, "is a scan, without faces: predict scans in a command of their own, with --category")


def _folder_names(shapes: Sequence[ShapeSource], places: Sequence[Path], above: Path) -> list[str]:
    """A name for the folder of each shape. `places` are the absolute paths of the shapes, all of them below `above`."""
    names = [short_name(shape.id, shape.id) for shape in shapes]
    for with_endings in (False, True):
        counts = Counter(names)
        keeping = Counter(name for name, shape in zip(names, shapes, strict=True) if shape.layout == PARTNET_MOBILITY)
        for index, shape in enumerate(shapes):
            name = names[index]
            keeps_id = shape.layout == PARTNET_MOBILITY and keeping[name] == 1
            if counts[name] > 1 and not keeps_id:
                names[index] = _path_name(places[index], above, with_endings)
    if len(set(names)) < len(names):  # a folder may have the name that a path becomes here
        names = [f"{number}-{name}" for number, name in enumerate(names)]
    return names


def _path_name(path: Path, above: Path, with_ending: bool) -> str:
    """Path of a shape below a folder as the name of one folder."""
    place = path.relative_to(above)
    text = printable_path("__".join((place if with_ending or path.is_dir() else place.with_suffix("")).parts)) or path.name
    return short_name(clean_text(text), text)
