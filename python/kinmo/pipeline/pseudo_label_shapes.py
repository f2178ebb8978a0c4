"""The stage `pseudo-label`: it predicts joints for unlabelled shapes, and keeps the accepted ones as labels."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import expecting
from kinmo.core.wording import counted
from kinmo.dataset.cache import Cache, Result, cache_key
from kinmo.dataset.jobs import Failure
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import ShapeDataset, open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.atomic_files import remove_leftovers, write_json_atomically
from kinmo.io.discover import ShapeSource
from kinmo.io.readers import PARTNET_MOBILITY
from kinmo.io.readers.partnet_annotation import PSEUDO_LABEL
from kinmo.io.writers import ExportOptions, export
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import DEFAULT_METHOD, load_method
from kinmo.methods.method import Method
from kinmo.pipeline.label_acceptance import LabelDecision, acceptance_report, decide, decision_from_data
from kinmo.pipeline.network_jobs import network_runner
from kinmo.pipeline.pseudo_label_files import LABEL, REPORT, label_name, labels_folder, stage_of

SECONDS_PER_SHAPE = 1.5  # first estimate, for one CPU core


@dataclass(frozen=True)
class PseudoLabel:
    """Label the unlabelled shapes of a workspace.

    The acceptance report covers all labels of the method, those of earlier runs for other categories too. Labels of shapes that
    are gone, or that have become labelled ones, are removed.
    """

    workspace: Workspace
    category: str | None = None
    method: str = DEFAULT_METHOD
    threshold: float | None = None  # score that every joint must exceed; None for that of the configuration
    device: str = "auto"
    workers: int = 1
    cluster: str | None = None  # address of a Ray cluster that runs the jobs; None for this machine

    def plan(self) -> Plan:
        """Count the shapes without an up-to-date decision."""
        dataset = open_dataset(self.workspace, self.category)
        settings = self._settings(load_method(self.method, self._models, self.device))
        # shapes that are gone are tried, and reported, each time; other stages need not wait for them
        jobs = [job for job in self._jobs(dataset, settings) if os.path.lexists(job.entry.source)]
        if not jobs:
            return Plan(() if self._is_reported(settings) else ("report on the current pseudo labels",), 0.0)
        copies = f", skip {len(dataset.copies)} copies of labelled shapes" if dataset.copies else ""
        return self._labelling(len(jobs), copies)

    def guess(self) -> Plan:
        """Estimate for labelling all shapes."""
        count = len(open_dataset(self.workspace, self.category).unlabelled)
        return self._labelling(count) if count else Plan((), 0.0)

    def _labelling(self, count: int, copies: str = "") -> Plan:
        each = seconds_per_unit(self.workspace, stage_of(self.method), SECONDS_PER_SHAPE / self.workers)
        return Plan((f"label {counted(count, 'shape')} by {self.method}{copies}",), count * each)

    def run(self, observer: Observer) -> Outcome:
        """Label the shapes without an up-to-date decision, and write the report."""
        dataset = open_dataset(self.workspace, self.category)
        method = load_method(self.method, self._models, self.device)
        settings, file = self._settings(method), self._folder / REPORT
        failures: list[str] = []
        with self.workspace.locked():
            jobs = self._jobs(dataset, settings)
            if not jobs and self._is_reported(settings):
                observer.note("already labelled")
            else:
                self.workspace.forget(stage_of(self.method))
                remove_leftovers(self._folder)
                whole = open_dataset(self.workspace)
                self._remove_stale(whole)
                failures = self._label(jobs, len(dataset.unlabelled), method, settings, observer)
                results = self._results(whole.unlabelled)
                decisions = [decision_from_data(result.data) for result in results if result is not None]
                outdated = _outdated(whole.unlabelled, results, settings)
                report = acceptance_report(decisions, self.method, len(whole.copies), outdated)
                write_json_atomically(file, report)
                self.workspace.record(stage_of(self.method), self._reported(settings), [file])
        with expecting("the report of kinmo pseudo-label", file):
            data = json.loads(file.read_text(encoding="utf-8"))
            return Outcome(self._folder, {**data, "failed": failures}, data["text"], len(failures))

    @property
    def _models(self) -> ModelFolder:
        return ModelFolder(self.workspace.models)

    @property
    def _folder(self) -> Path:
        return labels_folder(self.workspace, self.method)

    def _settings(self, method: Method) -> dict[str, Any]:
        """Everything but the shape that a decision depends on."""
        refinement = self._models.config().refinement
        threshold = refinement.least_score(self.method) if self.threshold is None else self.threshold
        predictor = {"method": method.name, "weights": method.weights, "config": dict(method.config)}
        return {**predictor, "threshold": threshold, "doubt": refinement.doubt}

    def _reported(self, settings: dict[str, Any]) -> dict[str, Any]:
        """Everything that the report depends on: the decisions on all shapes, and the last settings."""
        whole = open_dataset(self.workspace).unlabelled
        keys = [None if result is None else result.key for result in self._results(whole)]
        return {"decisions": cache_key(shapes=[label_name(entry) for entry in whole], keys=keys), **settings}

    def _is_reported(self, settings: dict[str, Any]) -> bool:
        return self.workspace.is_current(stage_of(self.method), self._reported(settings))

    def _results(self, entries: Sequence[IndexEntry]) -> list[Result | None]:
        """Decisions on some shapes; None where there is none, or its label is gone."""
        cache = Cache(self._folder)
        return [cache.find(label_name(entry)) for entry in entries]

    def _jobs(self, dataset: ShapeDataset, settings: dict[str, Any]) -> list[LabelJob]:
        """Shapes without a decision from the same files and settings."""
        jobs = []
        for entry, known in zip(dataset.unlabelled, self._results(dataset.unlabelled), strict=True):
            key = _key(entry, settings)
            if known is None or known.key != key:
                jobs.append(LabelJob(entry, self._folder / label_name(entry), key))
        return jobs

    def _remove_stale(self, whole: ShapeDataset) -> None:
        """Remove labels and decisions of shapes that are no unlabelled shapes any more."""
        names = {label_name(entry) for entry in whole.unlabelled}
        for folder in self._folder.glob("*"):
            if folder.is_dir() and folder.name not in names:
                shutil.rmtree(folder)
        cache = Cache(self._folder)
        cache.forget(*(name for name in cache if name not in names))

    def _label(
        self, jobs: Sequence[LabelJob], total: int, method: Method, settings: dict[str, Any], observer: Observer
    ) -> list[str]:
        """Decide on shapes. Returns the reasons of failures; a failed shape keeps its earlier label."""
        labeller = Labeller(self.workspace.prepared, method, settings["threshold"], settings["doubt"])
        cache = Cache(self._folder)
        done = total - len(jobs)
        failures: list[str] = []
        with timed(self.workspace, stage_of(self.method)) as watch:
            runner = network_runner(self.workers, self.device, self.cluster)
            with closing(runner.run(labeller, jobs)) as finished:  # no job outlives the lock
                for job, decision in finished:
                    if isinstance(decision, Failure):
                        failures.append(f"{job.entry.source}: cannot be labelled: {decision.reason}")
                    elif isinstance(decision, str):
                        failures.append(decision)
                    else:
                        files = [job.folder / LABEL] if decision.is_accepted else []
                        cache.store(job.folder.name, job.key, files, asdict(decision))
                    done += 1
                    observer.progress("labelling shapes", done, total, job.entry.id)
            watch.amount, watch.what = len(jobs), f"{counted(len(jobs), 'shape')} by {self.method}"
        if failures:
            others = f", and {len(failures) - 1} more" if len(failures) > 1 else ""
            observer.problem(f"failed: {failures[0]}{others}")
        return failures


def _key(entry: IndexEntry, settings: dict[str, Any]) -> str:
    return cache_key(shape=entry.key, settings=settings)


def _outdated(entries: Sequence[IndexEntry], results: Sequence[Result | None], settings: dict[str, Any]) -> list[str]:
    """Categories with decisions that anything but the threshold would change now."""
    outdated = set()
    for entry, result in zip(entries, results, strict=True):
        if result is not None and result.key != _key(entry, settings | {"threshold": result.data["threshold"]}):
            outdated.add(entry.category)
    return sorted(outdated)


@dataclass(frozen=True)
class LabelJob:
    """One shape to label into `folder`; `key` is the cache key of the decision."""

    entry: IndexEntry
    folder: Path
    key: str


@dataclass(frozen=True)
class Labeller:
    """Predicts shapes and writes the accepted labels, in any process; `store` is the folder of the prepared shapes."""

    store: Path
    method: Method
    threshold: float
    max_doubt: float

    def __call__(self, job: LabelJob) -> LabelDecision | str:
        """Decide on a shape. Returns a message if the shape cannot be read, which could when it was prepared."""
        entry = job.entry
        try:
            shape = ShapeSource.of(entry).read()
            prepared = read_prepared(self.store / entry.file)
            meshes = leaf_meshes(shape, prepared)
        except ValueError as error:
            return str(error)
        try:
            prediction = self.method.predict(prepared, meshes)
            decision = decide(prediction, entry.layout, self.threshold, self.max_doubt)
        except ValueError as error:
            refusal = f"failed: {error}"
            decision = LabelDecision(entry.id, entry.layout, entry.category, refusal=refusal, threshold=self.threshold)
        if decision.is_accepted:
            made = {"method": prediction.method, "weights": self.method.weights}
            facts = {"layout": entry.layout, "score": decision.score, **made}
            export(shape, prediction, job.folder, [PARTNET_MOBILITY], ExportOptions(meta={PSEUDO_LABEL: facts}))
        else:
            shutil.rmtree(job.folder, ignore_errors=True)
        return decision
