"""Export of one saved prediction with the corrections of its overrides.toml. No network is needed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kinmo.core.corrected_estimate import corrected_estimate
from kinmo.core.errors import InputError
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.core.wording import printable_path
from kinmo.dataset.cache import Cache
from kinmo.dataset.stage import Observer
from kinmo.io.readers.joints_json_reader import read_document
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE, read_overrides
from kinmo.io.result_folder import SavedResult, files_below, read_result, write_result
from kinmo.io.writers import check_formats
from kinmo.io.writers.joints_json_writer import FILE_NAME, joints_document
from kinmo.pipeline.joint_lines import joint_lines
from kinmo.robot.collision_geometry import CollisionMode

JOINTS_JSON, PARTNET_MOBILITY = "joints_json", "partnet_mobility"
"""Names of formats."""
UNCHECKED = (
    "nobody corrected these joints, so kinmo prepare does not take them as annotation; if they are right, put an empty "
    f"{OVERRIDES_FILE} beside {FILE_NAME}"
)
WITHOUT_CATEGORY = "the category is unknown: to state it, run kinmo predict again with --category"


@dataclass(frozen=True)
class ExportJob:
    """One saved prediction to export.

    Attributes:
        folder: the folder with joints.json, and maybe overrides.toml.
        target: the folder to write; `folder` to write it again.
        formats: names of formats. Written again, a folder keeps its own formats too. Empty for those alone.
        source: the file of the shape; None for the one that joints.json names.
        replaced: files of `target` that kinmo wrote, which are replaced. Other files stay.
        collision: how parts collide; None for that of the result.
        package: ROS package in the paths of URDFs; None for that of the result.
    """

    folder: Path
    target: Path
    formats: tuple[str, ...] = ()
    source: Path | None = None
    replaced: tuple[str, ...] = ()
    collision: CollisionMode | None = None
    package: str | None = None

    @property
    def is_in_place(self) -> bool:
        return self.folder == self.target


@dataclass(frozen=True)
class ExportedResult:
    """An exported prediction: plain data about it, a line for each joint, notes, and its files relative to the folder."""

    data: dict[str, Any]
    lines: tuple[str, ...]
    notes: tuple[str, ...]
    files: tuple[str, ...]


def export_result(job: ExportJob) -> ExportedResult | str:
    """Write the folder of a prediction with its corrections. Returns a message if that is impossible."""
    try:
        return _export(job)
    except InputError as error:
        return str(error)
    except OSError as error:
        return str(InputError(printable_path(error.filename or job.target), error.strerror or str(error)))


def corrected_result(job: ExportJob) -> tuple[SavedResult, tuple[str, ...]]:
    """The prediction to export, as overrides.toml corrects it, and its formats. Raises InputError if that is impossible."""
    check_formats(job.formats)
    saved = read_result(job.folder, job.source)
    file = job.folder / OVERRIDES_FILE
    estimate = saved.estimate.predicted
    if os.path.lexists(file):
        estimate = corrected_estimate(saved.shape, estimate, read_overrides(file))
    own = (*saved.options.formats, JOINTS_JSON)
    formats = (*own, *job.formats) if job.is_in_place else job.formats or own
    options = saved.options if job.collision is None else replace(saved.options, collision=job.collision)
    options = options if job.package is None else replace(options, package=job.package)
    return replace(saved, estimate=estimate, options=options), tuple(dict.fromkeys(formats))


def _export(job: ExportJob) -> ExportedResult:
    result, formats = corrected_result(job)
    options, file = result.options, job.folder / OVERRIDES_FILE
    kept, texts = set(files_below(job.target)) - set(job.replaced), {}
    if job.is_in_place:
        kept.add(OVERRIDES_FILE)
    if not job.is_in_place:
        options = replace(options, name=job.target.name)
        is_complete = JOINTS_JSON in formats and file.is_file()
        texts = {OVERRIDES_FILE: file.read_text(encoding="utf-8")} if is_complete else {}
    written = write_result(result.shape, result.estimate, job.target, formats, options, kept=kept, texts=texts)
    document = joints_document(result.shape, result.estimate, options)
    lines, notes = joint_lines(document), (*_notes(result.estimate, formats), *written.notes)
    data = {
        "id": result.shape.id,
        "folder": str(job.target),
        "category": result.estimate.category,
        "joints": len(lines),
        "corrected": result.estimate.correction is not None,
        "notes": list(notes),
        "files": {name: str(path) for name, path in written.main.items()},
    }
    return ExportedResult(data, tuple(lines), notes, written.files)


def _notes(estimate: ShapeEstimate, formats: Sequence[str]) -> tuple[str, ...]:
    notes = () if estimate.correction is None else estimate.correction.notes
    if PARTNET_MOBILITY not in formats:
        return notes
    unchecked = (UNCHECKED,) if estimate.correction is None else ()
    return (*notes, *unchecked, *(() if estimate.category else (WITHOUT_CATEGORY,)))


def edited_file(cache: Cache, name: str, *, is_in_place: bool) -> str | None:
    """A message if a person edited a file of the result `name`, which an export would replace.

    overrides.toml is there to be edited, and is replaced only by that of another folder.
    """
    edited = [path for path in cache.edited(name) if not (is_in_place and path == cache.folder / name / OVERRIDES_FILE)]
    if not edited:
        return None
    remedy = f"move it away, then run kinmo export again; corrections belong into {OVERRIDES_FILE}"
    if edited[0].name == FILE_NAME:
        remedy = f"move it away, then run kinmo predict again; corrections belong into {OVERRIDES_FILE}"
    return str(InputError(edited[0], f"was edited after kinmo wrote it: {remedy}"))


def files_of(cache: Cache, name: str) -> tuple[str, ...]:
    """Files of the result `name`, as paths relative to its folder, which `cache` records."""
    known = cache.latest(name)
    return () if known is None else tuple(Path(path).relative_to(name).as_posix() for path in known.files)


def keep_current(cache: Cache, folder: Path, files: Sequence[str]) -> None:
    """Record the files that replaced those of a prediction, so that kinmo predict regards it as up to date.

    `cache` is the one beside the folder.
    """
    name = folder.resolve().name
    if name in cache:
        written = [cache.folder / name / file for file in files]
        cache.renew(name, written, [cache.folder / name / OVERRIDES_FILE])


def apply_overrides(folders: Sequence[Path], observer: Observer) -> dict[Path, str]:
    """Write those predictions again whose overrides.toml is new, has changed, or is gone.

    `folders` lie beside each other, and the caller holds the lock of the folder around them. Returns a message for each that
    cannot be corrected, by its folder.
    """
    problems: dict[Path, str] = {}
    outdated = [folder for folder in folders if _is_outdated(folder)]
    cache = Cache(outdated[0].parent) if outdated else None
    for folder in outdated:
        assert cache is not None
        job = ExportJob(folder, folder, replaced=files_of(cache, folder.name))
        result = edited_file(cache, folder.name, is_in_place=True) or export_result(job)
        if isinstance(result, str):
            problems[folder] = result
            observer.problem(f"not corrected: {result}")
        else:
            keep_current(cache, folder, result.files)
    return problems


def _is_outdated(folder: Path) -> bool:
    """True if joints.json does not have the corrections of overrides.toml, or overrides.toml cannot be used."""
    file = folder / OVERRIDES_FILE
    try:
        correction = read_document(folder / FILE_NAME)["correction"]
        applied = None if correction.is_absent else correction["overrides"].value
    except InputError:
        return False
    try:
        return applied != (read_overrides(file).table if os.path.lexists(file) else None)
    except InputError:
        return True
