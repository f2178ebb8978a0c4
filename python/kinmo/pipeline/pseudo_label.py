"""Pseudo labels for the shapes of a workspace that have no joints."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.core.errors import expecting
from kinmo.core.wording import counted
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import Dataset, open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workers import Crashed
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.atomic_files import remove_leftovers, write_text_atomically
from kinmo.io.readers import Found, Layout, read_found
from kinmo.io.readers.partnet_annotation import PSEUDO_LABEL
from kinmo.io.writers.partnet_mobility_writer import write_partnet_mobility
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import load_method
from kinmo.methods.method import Method
from kinmo.pipeline.each_shape import each_shape
from kinmo.pipeline.label_acceptance import ACCEPTANCE, LABELLING, Judgement, judge
from kinmo.pipeline.label_decisions import (
    DECISIONS,
    LABELS,
    Decision,
    acceptance,
    decision_path,
    folder_name,
    read_decision,
    write_decision,
)

SECONDS_PER_SHAPE = 1.5


@dataclass(frozen=True)
class PseudoLabel:
    """Label the unlabelled shapes by the method of the workspace, all or those of one category.

    `threshold` None is that of the configuration. The acceptance report is of everything that is labelled, also by earlier runs
    for other categories. Labels of shapes that are no longer there, or have become labelled ones, are removed.
    """

    workspace: Workspace
    category: str | None = None
    threshold: float | None = None
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        dataset = open_dataset(self.workspace, self.category)
        way = self._way(load_method(self.workspace.method, ModelFolder(self.workspace.motion.models), self.device))
        # what has gone is tried, and told, each time, but nothing can come of it that others wait for
        jobs = [job for job in self._jobs(dataset, way) if os.path.lexists(job.entry.source)]
        if not jobs and self._is_reported(way):
            return Plan((), 0.0)
        if not jobs:
            return Plan(("report on the pseudo labels that there are now",), 0.0)
        copies = f", {len(dataset.copies)} copies of labelled shapes left alone" if dataset.copies else ""
        return self._labelling(len(jobs), copies)

    def _labelling(self, count: int, copies: str = "") -> Plan:
        each = seconds_per_unit(self.workspace, LABELLING, SECONDS_PER_SHAPE / self.workers)
        return Plan((f"label {counted(count, 'shape')} by {self.workspace.method}{copies}",), count * each)

    def guess(self) -> Plan:
        """Labelling all shapes."""
        count = len(open_dataset(self.workspace, self.category).unlabelled)
        return self._labelling(count) if count else Plan((), 0.0)

    def run(self, observer: Observer) -> Outcome:
        dataset = open_dataset(self.workspace, self.category)
        predictor = load_method(self.workspace.method, ModelFolder(self.workspace.motion.models), self.device)
        way = self._way(predictor)
        failures: list[str] = []
        with self.workspace.locked():
            jobs = self._jobs(dataset, way)
            if not jobs and self._is_reported(way):
                observer.note("labelled already")
            else:
                self.workspace.forget(LABELLING)
                remove_leftovers(self.workspace.pseudo)
                whole = open_dataset(self.workspace)
                self._remove_stale(whole)
                failures = self._label(jobs, len(dataset.unlabelled), predictor, way, observer)
                known = self._decisions(whole.unlabelled)
                decisions = [decision for decision in known if decision is not None]
                report = acceptance(decisions, self.workspace.method, len(whole.copies), _outdated(whole, known, way))
                write_text_atomically(self._report, json.dumps(report, indent=1, ensure_ascii=False) + "\n")
                outputs = [str(self._report.relative_to(self.workspace.path))]
                self.workspace.write_record(LABELLING, StageRecord(self._reported(way), tuple(outputs)))
        with expecting("the report of kinmo pseudo-label", self._report):
            data = json.loads(self._report.read_text(encoding="utf-8"))
            return Outcome(self.workspace.pseudo, {**data, "failed": failures}, data["text"], len(failures))

    @property
    def _report(self) -> Path:
        return self.workspace.pseudo / ACCEPTANCE

    def _way(self, predictor: Method) -> dict[str, Any]:
        way = {"method": predictor.name, "weights": predictor.weights, "config": dict(predictor.config)}
        told = ModelFolder(self.workspace.motion.models).config().refinement
        threshold = told.least_score(self.workspace.method) if self.threshold is None else self.threshold
        return {**way, "threshold": threshold, "doubt": told.doubt, "kinmo": __version__}

    def _reported(self, way: dict[str, Any]) -> dict[str, Any]:
        """What the report is of: the decisions on all shapes, whatever run made them, and the way of the last one."""
        whole = open_dataset(self.workspace).unlabelled
        made_from = [None if decision is None else decision.made_from for decision in self._decisions(whole)]
        return {"decisions": digest([[folder_name(entry) for entry in whole], made_from]), **way}

    def _is_reported(self, way: dict[str, Any]) -> bool:
        return self.workspace.is_current(LABELLING, self._reported(way))

    def _decisions(self, entries: Sequence[IndexEntry]) -> list[Decision | None]:
        return [read_decision(decision_path(self.workspace, entry)) for entry in entries]

    def _jobs(self, dataset: Dataset, way: dict[str, Any]) -> list[Job]:
        """The shapes on which nothing has been decided from the same files in the same way, or whose labels are gone."""
        jobs = []
        for entry, known in zip(dataset.unlabelled, self._decisions(dataset.unlabelled), strict=True):
            job = Job(entry, self.workspace.pseudo / folder_name(entry), _made_from(dataset, entry, way))
            is_there = known is not None and (not known.judgement.is_accepted or (job.folder / LABELS).exists())
            if known is None or known.made_from != job.made_from or not is_there:
                jobs.append(job)
        return jobs

    def _remove_stale(self, whole: Dataset) -> None:
        """Remove folders and decisions that belong to none of the unlabelled shapes that there are."""
        names = {folder_name(entry) for entry in whole.unlabelled}
        for folder in self.workspace.pseudo.glob("*"):
            if folder.is_dir() and folder.name not in names | {DECISIONS}:
                shutil.rmtree(folder)
        for decision in (self.workspace.pseudo / DECISIONS).glob("*.json"):
            if decision.name.removesuffix(".json") not in names:
                decision.unlink()

    def _label(self, jobs: Sequence[Job], total: int, predictor: Method, way: dict[str, Any], observer: Observer) -> list[str]:
        """Decide on all shapes but those that it fails on, of which it returns why: of these everything stays as it was."""
        labelling = Labelling(self.workspace.prepared, predictor, way["threshold"], way["doubt"])
        done = total - len(jobs)
        failures: list[str] = []
        with timed(self.workspace, LABELLING) as watch:
            for job, judgement in each_shape(labelling, jobs, self.workers, self.device):
                if isinstance(judgement, Crashed):
                    failures.append(f"{job.entry.source}: cannot be labelled: {judgement.why}")
                elif isinstance(judgement, str):
                    failures.append(judgement)
                else:
                    decision = Decision(judgement, job.made_from, way["threshold"])
                    write_decision(decision_path(self.workspace, job.entry), decision)
                done += 1
                observer.progress("labelling shapes", done, total, job.entry.id)
            watch.amount, watch.what = len(jobs), f"{counted(len(jobs), 'shape')} by {self.workspace.method}"
        if failures:
            others = f", and so {len(failures) - 1} more" if len(failures) > 1 else ""
            observer.problem(f"failed: {failures[0]}{others}")
        return failures


def _made_from(dataset: Dataset, entry: IndexEntry, way: dict[str, Any]) -> str:
    return digest([dataset.fingerprint([entry]), way])


def _outdated(whole: Dataset, decisions: Sequence[Decision | None], way: dict[str, Any]) -> list[str]:
    """Categories with decisions on shapes that something else than the threshold of `way` would make others of now."""
    known = ((entry, each) for entry, each in zip(whole.unlabelled, decisions, strict=True) if each is not None)
    return sorted(
        {
            entry.category
            for entry, decision in known
            if decision.made_from != _made_from(whole, entry, way | {"threshold": decision.threshold})
        }
    )


@dataclass(frozen=True)
class Job:
    """One shape to label into `folder`; `made_from` is a hash of all that the decision depends on."""

    entry: IndexEntry
    folder: Path
    made_from: str


@dataclass(frozen=True)
class Labelling:
    """Predicts shapes and writes those that are accepted, in whatever process. `store` is the folder of the prepared shapes."""

    store: Path
    predictor: Method
    threshold: float
    doubt: float

    def __call__(self, job: Job) -> Judgement | str:
        """The judgement; or why the shape could not be read, which says nothing of it: it could be when it was prepared."""
        entry = job.entry
        try:
            shape = read_found(Found(Path(entry.source), Layout(entry.layout), entry.id))
            prepared = read_prepared(self.store / entry.file)
            meshes = leaf_meshes(shape, prepared)
        except ValueError as error:
            return str(error)
        try:
            prediction = self.predictor.predict(prepared, meshes)
        except ValueError as error:
            shutil.rmtree(job.folder, ignore_errors=True)
            return Judgement(entry.id, entry.layout, entry.category, refusal=f"failed: {error}")
        judgement = judge(prediction, entry.layout, self.threshold, self.doubt)
        if judgement.is_accepted:
            made_by = {
                "layout": entry.layout,
                "score": judgement.score,
                "method": prediction.method,
                "weights": self.predictor.weights,
            }
            write_partnet_mobility(shape, prediction.mobility, job.folder, meta={PSEUDO_LABEL: made_by})
        else:
            shutil.rmtree(job.folder, ignore_errors=True)
        return judgement
