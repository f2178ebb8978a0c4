"""The stage `export`: it writes saved predictions again, with the corrections of their overrides.toml."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.core.names import short_name
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.dataset.cache import FILE as CACHE_FILE
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure, runner_for
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.atomic_files import restore_replaced
from kinmo.io.folder_lock import locked
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.writers import check_formats
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.pipeline.result_export import (
    ExportedResult,
    ExportJob,
    corrected_result,
    edited_file,
    export_result,
    files_of,
    keep_current,
)
from kinmo.robot.collision_geometry import CollisionMode

SECONDS_PER_RESULT = 1.0  # estimate, for one CPU core
JOBS_PER_PROCESS = 8
PACKAGE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
"""Names of ROS packages."""
MAX_LISTED_RESULTS = 10  # largest number of results whose joints are listed on the terminal


@dataclass(frozen=True)
class ExportResults:
    """Export the prediction in a folder, or all predictions below it, each with its own overrides.toml.

    Without `out`, the folders are written again, with their own formats and `formats`. Files that kinmo did not write stay.
    With `out`, each prediction gets a folder in it. With a package too, the folder has the name of the package. Without `out`,
    it must have that name already.
    """

    results: Path
    formats: tuple[str, ...] = ()
    out: Path | None = None
    source: Path | None = None  # file of the shape, if it is no longer where joints.json says; for one prediction alone
    workers: int = 1
    collision: CollisionMode | None = None  # how parts collide; None for that of each result
    package: str | None = None  # ROS package in the paths of URDFs; None for that of each result

    def plan(self) -> Plan:
        """Read all predictions and corrections."""
        steps, impossible = [], []
        caches = _Caches()
        for job in self._jobs(caches):
            try:
                problem = _obstacle(job, caches)
                result, formats = corrected_result(job)
            except InputError as error:
                problem = str(error)
            if problem is not None:
                impossible.append(problem)
                continue
            words = "" if result.estimate.correction is None else f", corrected by {OVERRIDES_FILE}"
            steps.append(f"write {job.target}: {', '.join(formats)}{words}")
        return Plan(tuple(steps), len(steps) * SECONDS_PER_RESULT / self.workers, tuple(impossible), len(impossible))

    def run(self, observer: Observer) -> Outcome:
        """Export all predictions. One that cannot be exported does not stop the others."""
        with ExitStack() as locks:
            for folder in self._locked_folders():
                locks.enter_context(locked(folder))
                restore_replaced(folder)
            caches = _Caches()
            jobs = self._jobs(caches)
            results = self._export(jobs, caches, observer)
        exported = [(job, result) for job in jobs if isinstance(result := results[job.folder], ExportedResult)]
        skipped = [result for result in results.values() if isinstance(result, str)]
        for job, result in exported:
            for note in result.notes:
                observer.note(f"{clean_text(job.target.name)}: {note}")
            if self.package and not job.is_in_place:
                observer.note(f"written into {job.target}: ROS looks for package://{self.package}/ in a folder of that name")
        lines = []
        for job, result in exported:  # several results may have the same id, but not the same folder
            category = clean_text(result.data["category"]) or "unknown"
            lines += [f"{clean_text(job.target.name)} (category {category})", *result.lines]
        joints = counted(sum(result.data["joints"] for _, result in exported), "joint")
        corrected = sum(result.data["corrected"] for _, result in exported)
        total = f"{counted(len(exported), 'result')}, {joints}, {corrected} corrected, {len(skipped)} skipped"
        text = "\n".join([*lines, total]) if len(exported) <= MAX_LISTED_RESULTS else total
        path = jobs[0].target if len(jobs) == 1 else self.out or self.results
        return Outcome(
            path if exported else None,
            {"results": [each.data for _, each in exported], "skipped": skipped},
            text,
            failed=len(skipped),
        )

    def _export(self, jobs: list[ExportJob], caches: _Caches, observer: Observer) -> dict[Path, ExportedResult | str]:
        """Results, or messages about problems, by folder."""
        results: dict[Path, ExportedResult | str] = {job.folder: "" for job in jobs}
        possible = []
        for job in jobs:
            problem = _obstacle(job, caches)
            if problem is None:
                possible.append(job)
            else:
                results[job.folder] = problem
        runner = runner_for(self.workers, jobs_per_worker=JOBS_PER_PROCESS)
        with closing(runner.run(export_result, possible)) as finished:
            for done, (job, answer) in enumerate(finished, 1):
                if isinstance(answer, Failure):
                    answer = f"{printable_path(job.folder)}: cannot be exported: {answer.reason}"
                if isinstance(answer, ExportedResult):
                    _record(job, answer, caches)
                results[job.folder] = answer
                observer.progress("exporting", done, len(possible), job.folder.name)
        for result in results.values():
            if isinstance(result, str):
                observer.problem(f"skipped: {result}")
        return results

    @property
    def _root(self) -> Path:
        return self.results.parent if self.results.name in (FILE_NAME, OVERRIDES_FILE) else self.results

    def _folders(self) -> list[Path]:
        """Folders of all predictions. Raises InputError if there is none, or an option is wrong."""
        check_formats(self.formats)
        if self.package and not PACKAGE_NAME.fullmatch(self.package):
            raise InputError("--package", f"expected a name of letters, digits, - and _, got {clean_text(self.package)}")
        folders = [folder for folder in find_results(self._root) if not self._is_own_export(folder)]
        if not folders:
            raise InputError(self.results, f"expected a result of kinmo predict, with {FILE_NAME}, at or below it")
        if self.source is not None and len(folders) > 1:
            raise InputError("--source", f"applies only to one result; found {len(folders)} below {self._root}")
        if self.package and len(folders) > 1:
            problem = f"applies only to one result; found {len(folders)} below {self._root}: export each by itself"
            raise InputError("--package", problem)
        if self.package and self.out is None and (name := folders[0].resolve().name) != self.package:
            problem = f"ROS looks for it in a folder of that name, not in {name}: add -o FOLDER to write FOLDER/{self.package}"
            raise InputError("--package", problem)
        return folders

    def _is_own_export(self, folder: Path) -> bool:
        """True for a folder in `out`, where `out` lies below the results: an earlier export of them."""
        if self.out is None or self._root.resolve().is_relative_to(self.out.resolve()):
            return False
        return folder.resolve() != self.out.resolve() and folder.resolve().is_relative_to(self.out.resolve())

    def _jobs(self, caches: _Caches) -> list[ExportJob]:
        """One job for each prediction."""
        jobs = []
        for folder in self._folders():
            target = folder if self.out is None else self.out / (self.package or self._name(folder))
            if self.out is not None and target.resolve() == folder.resolve():
                raise InputError("--out", f"{folder} would be replaced: leave --out away to write results again")
            if self.out is not None and self.out.resolve().is_relative_to(folder.resolve()):
                raise InputError("--out", f"lies in the result {folder}: name a folder elsewhere")
            real = target.resolve()
            replaced = files_of(caches[real.parent], real.name)
            jobs.append(ExportJob(folder, target, self.formats, self.source, replaced, self.collision, self.package))
        by_target: dict[Path, Path] = {}
        for job in jobs:
            if (other := by_target.setdefault(job.target, job.folder)) != job.folder:
                raise InputError("--out", f"{other} and {job.folder} would both be {job.target}: export one of them by itself")
        return jobs

    def _name(self, folder: Path) -> str:
        """Name in `out`: that of the folder, or its path if it lies deeper."""
        name = "__".join(folder.relative_to(self._root).parts or (folder.resolve().name,))
        return short_name(name, name)

    def _locked_folders(self) -> list[Path]:
        """Folders that other kinmo processes must not write into: those of kinmo predict, and `out`."""
        parents = {folder.resolve().parent for folder in self._folders()}
        return sorted(parent for parent in parents if (parent / CACHE_FILE).is_file()) if self.out is None else [self.out]


class _Caches(dict[Path, Cache]):
    """The records of kinmo predict and kinmo export by folder, each read once."""

    def __missing__(self, folder: Path) -> Cache:
        return self.setdefault(folder, Cache(folder))


def _obstacle(job: ExportJob, caches: _Caches) -> str | None:
    """A message if the target has files that must not be replaced."""
    target = job.target.resolve()
    cache = caches[target.parent]
    is_free = job.is_in_place or not os.path.lexists(target) or (target.is_dir() and not any(target.iterdir()))
    if not is_free and cache.data(target.name) != _record_of(job):
        return str(InputError(job.target, "exists, and is no export of the same result: name another folder by --out"))
    return edited_file(cache, target.name, is_in_place=job.is_in_place)


def _record(job: ExportJob, result: ExportedResult, caches: _Caches) -> None:
    """Record the files of a target."""
    target = job.target.resolve()
    cache = caches[target.parent]
    if job.is_in_place:
        keep_current(cache, target, result.files)
    else:
        data = _record_of(job)
        cache.store(target.name, cache_key(**data), [target / file for file in result.files], data)


def find_results(root: Path) -> Iterator[Path]:
    """Folders with joints.json at or below a folder, in the order of their names. Hidden folders and links are skipped."""
    if not root.is_dir():
        raise InputError(root, "expected a folder of kinmo predict" if root.exists() else "no such folder")
    if (root / FILE_NAME).is_file():
        yield root
        return
    for place, folders, files in os.walk(root):
        if FILE_NAME in files:
            folders.clear()
            yield Path(place)
        folders[:] = sorted(name for name in folders if not name.startswith("."))


def _record_of(job: ExportJob) -> dict[str, Any]:
    """Data by which the export of a result is recognised."""
    return {"result": printable_path(job.folder.resolve())}
