"""The folder with the prediction for one shape: joints.json, the exports, and overrides.toml if a person corrected it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS
from kinmo.core.shape import Shape
from kinmo.core.shape_digest import shape_digest
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.core.wording import printable_path
from kinmo.io.atomic_files import write_folder_atomically
from kinmo.io.discover import ShapeSource, discover
from kinmo.io.readers import READERS
from kinmo.io.readers.joints_json_reader import prediction_in, read_document
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.readers.stated_facts import StatedFacts
from kinmo.io.writers import ExportOptions, check_formats, write_formats
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.io.writers.writer import is_file_name
from kinmo.robot.collision_geometry import COLLISION_MODES, DEFAULT_MODE, CollisionMode
from kinmo.robot.physics import DEFAULT_PHYSICS, Physics

PREDICT_AGAIN = "run kinmo predict again, which keeps overrides.toml"
"""Remedy for a result that no longer fits the file of its shape."""


@dataclass(frozen=True, eq=False)
class SavedResult:
    """The prediction in a folder, with all that is needed to write the folder again.

    Attributes:
        shape: the shape, read from its source.
        estimate: the prediction, maybe corrected, as joints.json has it.
        options: settings and formats of the export.
    """

    shape: Shape
    estimate: ShapeEstimate
    options: ExportOptions


@dataclass(frozen=True)
class WrittenResult:
    """Files of a written folder.

    Attributes:
        main: path of the main file of each format.
        files: paths of all written files, relative to the folder.
        notes: one line for everything that a user should know about the export.
    """

    main: Mapping[str, Path]
    files: tuple[str, ...]
    notes: tuple[str, ...] = ()


def read_result(folder: Path, source: Path | None = None) -> SavedResult:
    """Read the prediction in a folder, and its shape.

    Args:
        folder: a folder with joints.json.
        source: the file or folder of the shape. None for the one that joints.json names.

    Raises:
        InputError: joints.json or the shape cannot be read, or the shape has changed since the prediction.
    """
    file = folder / FILE_NAME
    document = read_document(file)
    facts = document["shape"]
    shape = _shape_of(facts, source)
    if not facts["digest"].is_absent and facts["digest"].text() != shape_digest(shape):
        what = "has changed" if shape.labels is None else f"it or its labels {printable_path(shape.labels)} changed"
        raise InputError(shape.source, f"{what} since the prediction in {folder}: {PREDICT_AGAIN}")
    try:
        estimate, provenance = prediction_in(document, shape)
    except InputError as error:
        raise InputError(error.where, f"{error.problem}: {PREDICT_AGAIN}", error.field) from None
    return SavedResult(shape, estimate, replace(_options(folder, document), provenance=provenance))


def _options(folder: Path, document: JsonField) -> ExportOptions:
    """Settings of the export of a result, as its joints.json has them, without the provenance."""
    export = document["export"]
    if export.is_absent:
        return ExportOptions(folder.resolve().name)
    scale = export["metres_per_unit"].number()
    if scale <= 0.0:
        raise export["metres_per_unit"].fail("expected a positive number")
    if not is_file_name(export["name"].text()):
        raise export["name"].fail("expected a file name without folders")
    name, formats = export["name"].text(), tuple(item.text() for item in export["formats"].items())
    package = "" if export["package"].is_absent else export["package"].text()
    collision, physics = _collision(export["collision"]), _physics(export["physics"])
    return ExportOptions(name, scale, formats=formats, collision=collision, physics=physics, package=package)


def _collision(field: JsonField) -> CollisionMode:
    modes: dict[str, CollisionMode] = {mode: mode for mode in COLLISION_MODES}
    if field.is_absent:
        return DEFAULT_MODE
    if field.text() not in modes:
        raise field.fail(f"expected one of {', '.join(modes)}")
    return modes[field.text()]


def _physics(field: JsonField) -> Physics:
    if field.is_absent:
        return DEFAULT_PHYSICS
    names = {} if field["part_densities"].is_absent else field["part_densities"].value
    if not isinstance(names, dict):
        raise field["part_densities"].fail("expected an object")
    densities = {name: field["part_densities"][name].number() for name in names}
    damping, friction = (None if field[name].is_absent else field[name].number() for name in ("damping", "friction"))
    others = {name: field[name].number(getattr(DEFAULT_PHYSICS, name)) for name in ("density", "effort", "velocity")}
    try:
        return Physics(part_densities=densities, damping=damping, friction=friction, **others)
    except InputError as error:
        raise InputError(field.where, error.problem, f"{field.path}.{error.field}") from None


def options_in(folder: Path) -> ExportOptions:
    """Settings of the export of a result, without the provenance. The usual ones without a joints.json that can be read."""
    try:
        return _options(folder, read_document(folder / FILE_NAME))
    except InputError:
        return ExportOptions(folder.resolve().name)


def write_result(
    shape: Shape,
    estimate: ShapeEstimate,
    folder: Path,
    formats: Sequence[str],
    options: ExportOptions,
    *,
    kept: Collection[str] = (OVERRIDES_FILE,),
    texts: Mapping[str, str] | None = None,
) -> WrittenResult:
    """Write a prediction into a folder, which is replaced as a whole. If the export fails, it is unchanged.

    Args:
        shape: the shape.
        estimate: its prediction.
        folder: the folder.
        formats: names of formats, keys of `kinmo.io.writers.WRITERS`.
        options: settings of the export.
        kept: files of the present folder to keep, as paths relative to it, unless the export writes them anew.
        texts: texts of further files, by name.
    """
    check_formats(formats)
    target = folder.resolve()  # a link to the folder stays a link
    with write_folder_atomically(target) as draft:
        notes: list[str] = []
        main = write_formats(shape, estimate, draft, formats, options, notes)
        for name, text in (texts or {}).items():
            (draft / name).write_text(text, encoding="utf-8")
        written = tuple(sorted(files_below(draft)))
        for name in kept:
            _keep(target / name, draft / name)
    return WrittenResult({name: folder / path.relative_to(draft) for name, path in main.items()}, written, tuple(notes))


def files_below(folder: Path) -> Iterator[str]:
    """All files and links in a folder and its subfolders, as paths relative to it."""
    for place, folders, files in os.walk(folder):
        links = [name for name in folders if (Path(place) / name).is_symlink()]
        for name in (*files, *links):
            yield (Path(place) / name).relative_to(folder).as_posix()


def _keep(old: Path, new: Path) -> None:
    """Copy a file or link, if it exists and nothing is in its place."""
    if os.path.lexists(old) and not os.path.lexists(new):
        new.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(old, new, follow_symlinks=False)


def _shape_of(facts: JsonField, source: Path | None) -> Shape:
    """The shape of a prediction, with the facts that the prediction states of it.

    The up direction and the labels decide what the parts are, so the reader needs them.
    """
    up, labels = _direction(facts["up"]), facts["labels"]
    axis = next((name for name, vector in AXIS_VECTORS.items() if vector == up), None)
    stated = StatedFacts(up=axis, labels=None if labels.is_absent else Path(labels.whole_text()))
    if stated.labels is not None and not os.path.lexists(stated.labels):
        raise InputError(printable_path(stated.labels), f"missing: put the labels of the parts back, or {PREDICT_AGAIN}")
    guessed = facts["guessed"].value
    guesses = {name: facts["guessed"][name].whole_text() for name in guessed} if isinstance(guessed, dict) else {}
    return replace(
        _source(facts, source).read(stated),
        id=facts["id"].text(),
        category=facts["category"].text(""),
        up=up,
        front=None if facts["front"].value is None else _direction(facts["front"]),
        metres_per_unit=facts["metres_per_unit"].number(1.0),
        guesses=guesses,
        repairs=tuple(repair.whole_text() for repair in facts["repairs"].items()),
    )


def _direction(field: JsonField) -> tuple[float, float, float]:
    x, y, z = field.vector().tolist()
    return x, y, z


def _source(facts: JsonField, source: Path | None) -> ShapeSource:
    if source is not None:
        found = list(discover(source))
        if len(found) != 1:
            raise InputError(source, f"expected one shape, found {len(found)}")
        return found[0]
    layout, place = facts["layout"], Path(facts["source"].whole_text())
    if layout.text() not in READERS:
        raise layout.fail(f"expected one of {', '.join(READERS)}")
    if not os.path.lexists(place):
        raise InputError(printable_path(place), "missing: name the file of the shape by --source")
    return ShapeSource(place, layout.text(), facts["id"].text())
