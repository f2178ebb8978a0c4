"""The stage `predict` for shapes: it predicts joints of users' own objects, and writes joints.json and URDF."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.categories import KNOWN_CATEGORIES, known_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.frames import y_up_rotation
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import PredictionProvenance, ShapeEstimate
from kinmo.core.wording import clean_text, counted, printable_path
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.atomic_files import restore_replaced
from kinmo.io.discover import ShapeSource
from kinmo.io.folder_lock import locked
from kinmo.io.readers.overrides_reader import OVERRIDES_FILE
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import plain_path
from kinmo.io.result_folder import files_below, write_result
from kinmo.io.source_files import fingerprint
from kinmo.io.writers import ExportOptions, check_formats
from kinmo.io.writers.joints_json_writer import FILE_NAME
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import load_trained_or_shipped
from kinmo.methods.method import Method
from kinmo.pipeline.network_jobs import network_runner
from kinmo.pipeline.prediction_summary import notes_about, summary_of
from kinmo.pipeline.prediction_targets import prediction_targets
from kinmo.pipeline.removed_formats import EarlierResult, removed_line
from kinmo.pipeline.result_export import apply_overrides, files_of
from kinmo.robot.collision_geometry import CollisionMode

SECONDS_PER_SHAPE = 3.0  # estimate, for one CPU core
MAX_LISTED_SHAPES = 10  # largest number of shapes whose joints are listed on the terminal
MISSPELLED = 0.85  # similarity to a known category above which another one is probably misspelled
JOINTS_JSON = "joints_json"  # format that every result has


@dataclass(frozen=True)
class PredictShapes:
    """Predict every shape at or below some paths, each into a folder of its own. An unreadable shape does not stop the others.

    joints.json is in the frame and units of the shape's file. URDFs are z-up and in metres.
    """

    sources: Sequence[Path]
    out: Path
    workspace: Workspace
    method: str
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    facts: StatedFacts = NO_FACTS  # what the user states about all shapes
    cluster: str | None = None  # address of a Ray cluster that runs the jobs; None for this machine
    formats: tuple[str, ...] = ("urdf",)  # formats beside joints.json, keys of `kinmo.io.writers.WRITERS`
    collision: CollisionMode = "convex"  # how parts collide in a simulator

    def plan(self) -> Plan:
        """Count the shapes without an up-to-date prediction."""
        targets, _ = prediction_targets(self.sources, self.out)
        jobs, unreadable = self._pending(targets, self._writer(), Cache(self.out))
        count = len(jobs) + len(unreadable)
        step = f"predict {counted(count, 'shape')} into {self.out}"
        return Plan((step,) if count else (), count * SECONDS_PER_SHAPE / self.workers)

    def run(self, observer: Observer) -> Outcome:
        """Predict the shapes without an up-to-date prediction."""
        targets, skipped = prediction_targets(self.sources, self.out)
        for problem in skipped:
            observer.problem(f"skipped: {problem}")
        writer = self._writer()
        observer.note(f"networks: {writer.method.networks}")
        if self.facts.category and not known_category(self.facts.category):
            near = did_you_mean(self.facts.category, KNOWN_CATEGORIES, MISSPELLED)
            observer.note(f"--category {clean_text(self.facts.category)} is new to kinmo{near}")
        with locked(self.out):
            restore_replaced(self.out)
            problems = self._predict(targets, writer, observer)
            uncorrected = apply_overrides([folder for _, folder in targets if folder not in problems], observer)
        documents: list[dict[str, Any]] = []
        lines: list[str] = []
        for found, folder in targets:
            try:
                if folder in problems:
                    skipped.append(problems[folder])
                else:
                    document, own = summary_of(found, folder)
                    documents.append(document)
                    lines += own
            except InputError as error:
                skipped.append(str(error))
                observer.problem(f"skipped: {error}")
        for line in notes_about(documents, uncorrected):
            observer.note(line)
        repaired = sum(bool(document["repairs"]) for document in documents)
        count = counted(sum(document["joints"] for document in documents), "joint")
        repairs = f", {repaired} repaired" if repaired else ""
        total = f"{counted(len(documents), 'shape')}, {count}{repairs}, {len(skipped)} skipped"
        where = f"each joint with its score: {self.out / '*' / FILE_NAME}"
        text = "\n".join([*lines, total] if len(documents) <= MAX_LISTED_SHAPES else [total, where])
        data = {"shapes": documents, "skipped": skipped, "uncorrected": list(uncorrected.values())}
        return Outcome(self.out if documents else None, data, text, failed=len(skipped) + len(uncorrected))

    def _pending(
        self, targets: Sequence[tuple[ShapeSource, Path]], writer: PredictionWriter, cache: Cache
    ) -> tuple[list[PredictionJob], dict[Path, str]]:
        """Shapes without an up-to-date prediction, maybe edited, and by folder the problems with those that cannot be read."""
        jobs: list[PredictionJob] = []
        problems: dict[Path, str] = {}
        for found, folder in targets:
            try:
                key = writer.key(found)
            except InputError as error:
                problems[folder] = str(error)
                continue
            has_result = _stated_source(folder) is not None
            if has_result and cache.is_current(folder.name, key, edited=True):
                continue
            edited = [path for path in cache.edited(folder.name) if path.name != OVERRIDES_FILE] if has_result else []
            if edited:
                remedy = "move it away, or name another folder by --out"
                problems[folder] = str(InputError(edited[0], f"was edited after kinmo wrote it: {remedy}"))
            else:
                jobs.append(PredictionJob(found, folder, key, _source_in(cache, folder), files_of(cache, folder.name)))
        return jobs, problems

    def _predict(
        self, targets: Sequence[tuple[ShapeSource, Path]], writer: PredictionWriter, observer: Observer
    ) -> dict[Path, str]:
        """Predict shapes whose files or settings are new. Returns problems by folder."""
        cache = Cache(self.out)
        jobs, problems = self._pending(targets, writer, cache)
        for problem in problems.values():
            observer.problem(f"skipped: {problem}")
        done = len(targets) - len(jobs)
        earlier = {job.folder: EarlierResult.of(job.folder) for job in jobs}
        runner = network_runner(self.workers, self.device, self.cluster)
        with closing(runner.run(writer, jobs)) as finished:  # no job outlives the lock
            for job, answer in finished:
                if isinstance(answer, Failure):
                    answer = f"{printable_path(job.found.path)}: cannot be predicted: {answer.reason}"
                if isinstance(answer, str):
                    problems[job.folder] = answer
                    observer.problem(f"skipped: {answer}")
                else:
                    files = [job.folder / name for name in answer]
                    cache.store(job.folder.name, job.key, files, {"source": _source(job.found)})
                done += 1
                observer.progress("predicting joints", done, len(targets), clean_text(job.folder.name))
        if (line := removed_line(earlier, writer.formats)) is not None:
            observer.note(line)
        return problems

    def _writer(self) -> PredictionWriter:
        method = load_trained_or_shipped(self.method, ModelFolder(self.workspace.models), self.device)
        check_formats(self.formats)
        formats = tuple(dict.fromkeys((*self.formats, JOINTS_JSON)))
        return PredictionWriter(method, self.seed, self.facts, formats, self.collision)


def predict_shape(shape: Shape, method: Method, *, seed: int = 0) -> ShapeEstimate:
    """Predict the joints of one shape, in the shape's own frame and units; `seed` is that of the sampled points."""
    rotation = y_up_rotation(np.array(shape.up), None if shape.front is None else np.array(shape.front))
    standing = shape.rotated(rotation)
    prepared = prepare_shape(standing, seed=seed)
    return method.predict(prepared, leaf_meshes(standing, prepared)).rotated(rotation.T)


@dataclass(frozen=True)
class PredictionJob:
    """One shape to predict into `folder`.

    `written_for` is the source of the prediction that is there already, and `replaced` are its files. Other files stay.
    """

    found: ShapeSource
    folder: Path
    key: str
    written_for: str | None
    replaced: tuple[str, ...] = ()


@dataclass(frozen=True)
class PredictionWriter:
    """Predicts shapes and writes their folders, in any process."""

    method: Method
    seed: int
    facts: StatedFacts
    formats: tuple[str, ...]
    collision: CollisionMode

    def key(self, found: ShapeSource) -> str:
        """Cache key of a prediction. Raises InputError if the shape's files cannot be read."""
        settings = [self.method.name, self.method.weights, dict(self.method.config), self.seed, self.facts.key()]
        settings += [self.formats, self.collision]
        return cache_key(source=_source(found), files=fingerprint(found), settings=settings)

    def __call__(self, job: PredictionJob) -> list[str] | str:
        """Write the folder of a shape. Returns the names of its files, or a message if the shape cannot be predicted."""
        try:
            _check_replaceable(job)
            shape = job.found.read(self.facts)
            prediction = predict_shape(shape, self.method, seed=self.seed)
            provenance = PredictionProvenance(self.method.weights, self.method.config)
            options = ExportOptions(job.folder.name, shape.metres_per_unit, provenance=provenance, collision=self.collision)
            kept = (set(files_below(job.folder)) - set(job.replaced)) | {OVERRIDES_FILE}
            return list(write_result(shape, prediction, job.folder, self.formats, options, kept=kept).files)
        except ValueError as error:
            return str(error) if isinstance(error, InputError) else f"{printable_path(job.found.path)}: {error}"
        except OSError as error:
            problem = f"{printable_path(str(error.filename or job.folder))}: {error.strerror or error}"
            return str(InputError(job.found.path, problem))


def _source(found: ShapeSource) -> str:
    return printable_path(plain_path(found.path))


def _source_in(cache: Cache, folder: Path) -> str | None:
    """Source of the prediction that a folder holds, from the cache or else from its joints.json; None if it holds none."""
    data = cache.data(folder.name)
    return str(data["source"]) if isinstance(data, dict) and "source" in data else _stated_source(folder)


def _stated_source(folder: Path) -> str | None:
    """Source that the joints.json of a folder states; None if there is no such file."""
    try:
        return str(json.loads((folder / FILE_NAME).read_text(encoding="utf-8"))["shape"]["source"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _check_replaceable(job: PredictionJob) -> None:
    """Raise InputError if the folder holds anything but an earlier prediction for the same shape, and overrides.toml."""
    folder = job.folder
    if not os.path.lexists(folder) or (folder.is_dir() and {path.name for path in folder.iterdir()} <= {OVERRIDES_FILE}):
        return
    if job.written_for is None:
        raise InputError(folder, "exists, and kinmo predict did not write it: name another folder by --out")
    if job.written_for != _source(job.found):
        raise InputError(folder, f"exists, with the prediction for {job.written_for}: name another folder by --out")
