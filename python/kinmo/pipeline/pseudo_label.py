"""Pseudo labels for the shapes of a workspace that have no joints."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from kinmo import __version__
from kinmo.errors import expecting
from kinmo.export.partnet_mobility import write_partnet_mobility
from kinmo.formats import Found, Layout, read_found
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.each_shape import each_shape
from kinmo.pipeline.journal import seconds_per_unit, timed
from kinmo.pipeline.model_files import trained_config
from kinmo.pipeline.predictors import Predictor, leaf_meshes, load_predictor
from kinmo.pipeline.stage import Observer, Outcome, Plan
from kinmo.pseudo_label import ACCEPTANCE, LABELLING, STEPS, JudgedJoint, Judgement, Tally, judge, tally, tally_types
from kinmo.store import IndexEntry, read_prepared
from kinmo.workers import Crashed
from kinmo.workspace import StageRecord, Workspace, digest, remove_leftovers, write_text_atomically

DECISIONS = "decisions"
"""A file a shape, accepted or not, written when all else of the shape is: what was decided, and from what."""
SECONDS_PER_SHAPE = 1.5


@dataclass(frozen=True)
class PseudoLabel:
    """Label the unlabelled shapes, all or those of one category; `threshold` None is that of the configuration.

    The acceptance report is of everything that is labelled, also by earlier runs for other categories. Labels of shapes that
    are no longer there, or have become labelled ones, are removed.
    """

    workspace: Workspace
    method: str
    category: str | None = None
    threshold: float | None = None
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        dataset = open_dataset(self.workspace, self.category)
        predictor = load_predictor(self.workspace, self.method, self.device)
        count = len(dataset.unlabelled)
        if self.workspace.is_current(LABELLING, self._inputs(dataset, predictor)):
            return Plan((), 0.0)
        copies = f", {len(dataset.copies)} copies of labelled shapes left alone" if dataset.copies else ""
        each = seconds_per_unit(self.workspace, LABELLING, SECONDS_PER_SHAPE / self.workers)
        return Plan((f"label {count} shapes by {self.method}{copies}",), count * each)

    def run(self, observer: Observer) -> Outcome:
        dataset = open_dataset(self.workspace, self.category)
        predictor = load_predictor(self.workspace, self.method, self.device)
        with self.workspace.locked():
            inputs = self._inputs(dataset, predictor)
            if self.workspace.is_current(LABELLING, inputs):
                observer.note("labelled already")
            else:
                self.workspace.forget(LABELLING)
                remove_leftovers(self.workspace.pseudo)
                whole = open_dataset(self.workspace)
                self._remove_stale(whole)
                self._label(dataset, predictor, observer)
                report = acceptance(list(self._decided(whole)), len(whole.copies))
                write_text_atomically(self._report, json.dumps(report, indent=1, ensure_ascii=False) + "\n")
                outputs = [str(self._report.relative_to(self.workspace.path))]
                self.workspace.write_record(LABELLING, StageRecord(inputs, tuple(outputs)))
        with expecting("the report of kinmo pseudo-label", self._report):
            data = json.loads(self._report.read_text(encoding="utf-8"))
            return Outcome(self.workspace.pseudo, data, data["text"])

    @property
    def _report(self) -> Path:
        return self.workspace.pseudo / ACCEPTANCE

    def _inputs(self, dataset: Dataset, predictor: Predictor) -> dict[str, Any]:
        return {"data": dataset.fingerprint(dataset.unlabelled), **self._way(predictor)}

    def _way(self, predictor: Predictor) -> dict[str, Any]:
        way = {"method": predictor.method, "weights": predictor.weights, "config": dict(predictor.config)}
        told = trained_config(self.workspace).refinement
        threshold = told.threshold if self.threshold is None else self.threshold
        return {**way, "threshold": threshold, "doubt": told.doubt, "kinmo": __version__}

    def _remove_stale(self, whole: Dataset) -> None:
        """Remove folders and decisions that belong to none of the unlabelled shapes that there are."""
        names = {folder_name(entry) for entry in whole.unlabelled}
        for folder in self.workspace.pseudo.glob("*"):
            if folder.is_dir() and folder.name not in names | {DECISIONS}:
                shutil.rmtree(folder)
        for decision in (self.workspace.pseudo / DECISIONS).glob("*.json"):
            if decision.name.removesuffix(".json") not in names:
                decision.unlink()

    def _decided(self, whole: Dataset) -> Iterator[Decision]:
        """Every decision that was made, whatever run made it."""
        found = (read_decision(self._decision(entry)) for entry in whole.unlabelled)
        return (decision for decision in found if decision is not None)

    def _label(self, dataset: Dataset, predictor: Predictor, observer: Observer) -> None:
        """Decide on the shapes on which nothing has been decided from the same files in the same way."""
        jobs, way = [], self._way(predictor)
        for entry in dataset.unlabelled:
            made_from = digest([dataset.fingerprint([entry]), way])
            known = read_decision(self._decision(entry))
            if known is None or known.made_from != made_from:
                jobs.append(Job(entry, self.workspace.pseudo / folder_name(entry), made_from))
        labelling = Labelling(dataset.store.folder, predictor, way["threshold"], way["doubt"])
        done = len(dataset.unlabelled) - len(jobs)
        with timed(self.workspace, LABELLING) as watch:
            for job, judgement in each_shape(labelling, jobs, self.workers, self.device):
                if isinstance(judgement, Crashed):
                    judgement = labelling.refused(job, "the process that labelled it died")
                decision = Decision(judgement, job.made_from, self.method, way["threshold"])
                write_decision(self._decision(job.entry), decision)
                done += 1
                observer.progress("labelling shapes", done, len(dataset.unlabelled), job.entry.id)
            watch.amount, watch.what = len(jobs), f"{len(jobs)} shapes by {self.method}"

    def _decision(self, entry: IndexEntry) -> Path:
        return self.workspace.pseudo / DECISIONS / f"{folder_name(entry)}.json"


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
    predictor: Predictor
    threshold: float
    doubt: float

    def __call__(self, job: Job) -> Judgement:
        entry = job.entry
        try:
            shape = read_found(Found(Path(entry.source), Layout(entry.layout), entry.id))
            prepared = read_prepared(self.store / entry.file)
            prediction = self.predictor.predict(prepared, leaf_meshes(shape, prepared))
        except ValueError as error:
            return self.refused(job, str(error))
        judgement = judge(prediction, entry.layout, self.threshold, self.doubt)
        if judgement.is_accepted:
            made_by = {
                "layout": entry.layout,
                "score": judgement.score,
                "method": prediction.method,
                "weights": self.predictor.weights,
            }
            write_partnet_mobility(shape, prediction.mobility, job.folder, meta={"pseudo_label": made_by})
        else:
            shutil.rmtree(job.folder, ignore_errors=True)
        return judgement

    def refused(self, job: Job, reason: str) -> Judgement:
        """The judgement of a shape that got no prediction; whatever was written of it before goes."""
        shutil.rmtree(job.folder, ignore_errors=True)
        return Judgement(job.entry.id, job.entry.layout, job.entry.category, refusal=f"failed: {reason}")


def folder_name(entry: IndexEntry) -> str:
    """A folder's name: the id, and for what is not PartNet's, which may have the same ids, the layout."""
    name = quote(entry.id, safe=" ")
    return name if entry.layout == Layout.PARTNET.value else f"{name}-{entry.layout}"


@dataclass(frozen=True)
class Decision:
    """What was decided of a shape, by which method and threshold; `made_from` is a hash of all that it depends on."""

    judgement: Judgement
    made_from: str
    method: str
    threshold: float


def write_decision(path: Path, decision: Decision) -> None:
    """Write what was decided of a shape."""
    write_text_atomically(path, json.dumps(asdict(decision), ensure_ascii=False) + "\n")


def read_decision(path: Path) -> Decision | None:
    """What was decided of a shape; None if nothing was."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        judgement = data["judgement"]
        joints = tuple(JudgedJoint(**joint) for joint in judgement["joints"])
        return Decision(**{**data, "judgement": Judgement(**{**judgement, "joints": joints})})
    except (OSError, ValueError, KeyError, TypeError):
        return None


def acceptance(decisions: Sequence[Decision], copies: int) -> dict[str, Any]:
    """The acceptance report as plain data: `text`, `tables` (as `kinmo.report.page.Table` takes them) and every refusal."""
    judgements = [decision.judgement for decision in decisions]
    ways = sorted({f"all joints above {decision.threshold:g}, by {decision.method}" for decision in decisions})
    whole = tally(judgements)
    categories = sorted({judgement.category for judgement in judgements})
    by_category = {name: tally(j for j in judgements if j.category == name) for name in categories} | {"all": whole}
    reasons: dict[str, list[str]] = {}
    for judgement in judgements:
        if not judgement.is_accepted:
            reasons.setdefault(judgement.refusal, []).append(judgement.shape_id)
    text = (
        f"{whole.accepted} of {whole.shapes} shapes were accepted ({'; or '.join(ways) or 'there are none'}), with "
        f"{whole.accepted_joints} of {whole.joints} joints; {copies} copies of labelled shapes were left alone."
    )
    return {
        "text": text,
        "ways": ways,
        "copies": copies,
        "tables": [
            _counts("Pseudo labels by category", "category", by_category),
            _counts("Pseudo labels by motion type", "type", tally_types(judgements)),
            {
                "caption": "Refused",
                "header": ["reason", "shapes", "for example"],
                "rows": [
                    [reason, str(len(ids)), ids[0]] for reason, ids in sorted(reasons.items(), key=lambda item: -len(item[1]))
                ],
            },
        ],
        "refused": dict(sorted(reasons.items())),
    }


def _counts(caption: str, what: str, groups: Any) -> dict[str, Any]:
    header = [what, "shapes", "accepted", "joints", "accepted joints", *(f"> {step:g}" for step in STEPS)]

    def row(name: str, group: Tally) -> list[str]:
        counts = (group.shapes, group.accepted, group.joints, group.accepted_joints, *group.at_least)
        return [name, *map(str, counts)]

    note = "The columns on the right count joints that score more."
    return {"caption": caption, "header": header, "rows": [row(name, group) for name, group in groups.items()], "note": note}
