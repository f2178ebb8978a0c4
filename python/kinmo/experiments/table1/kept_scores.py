"""Judgements of test shapes: each is made once, and kept for as long as nothing that it depends on changes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.config import RefinementConfig
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.dataset.shape_dataset import Dataset
from kinmo.dataset.stage import Observer
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workers import Crashed
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.score_data import score_from_data, score_to_data
from kinmo.experiments.table1.evaluation_folder import JUDGEMENTS
from kinmo.experiments.table1.examples import example_from_data
from kinmo.experiments.table1.rows import Row
from kinmo.experiments.table1.shape_scores import Judgement, judge
from kinmo.experiments.table1.trees_answers import Answers, answer_to_data
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers import Found, Layout, read_found
from kinmo.pipeline.each_shape import each_shape


@dataclass(frozen=True)
class Job:
    """One shape to judge, with the answers of boosted trees if there are any; `made_from` is a hash of all that counts."""

    entry: IndexEntry
    trees: Answers | None
    made_from: str


@dataclass(frozen=True)
class Judge:
    """Judges shapes by some rows, in whatever process, into plain data. `store` is the folder of the prepared shapes."""

    store: Path
    rows: tuple[Row, ...]
    config: RefinementConfig

    def __call__(self, job: Job) -> dict[str, Any]:
        entry = job.entry
        truth = read_prepared(self.store / entry.file)
        shape = read_found(Found(Path(entry.source), Layout(entry.layout), entry.id))
        found = judge(truth, leaf_meshes(shape, truth), entry.layout, self.rows, self.config, job.trees)
        return judgement_to_data(found)

    def made_from(self, dataset: Dataset, entry: IndexEntry, trees: Answers | None) -> str:
        """A hash of all that the judgement of a shape depends on."""
        rows = {row.name: [row.predictor.weights, dict(row.predictor.config)] for row in self.rows}
        said = None if trees is None else {str(body): answer_to_data(answer) for body, answer in trees.items()}
        return digest([dataset.fingerprint([entry]), rows, to_table(self.config), said, __version__])


def judgements(
    workspace: Workspace,
    dataset: Dataset,
    entries: Sequence[IndexEntry],
    judging: Judge,
    trees: Mapping[str, Answers] | None,
    workers: int,
    device: str,
    observer: Observer,
) -> list[Judgement]:
    """The judgements of some shapes, in their order; those that are not kept already are made on so many processes."""
    found: dict[str, Judgement] = {}
    missing = []
    for entry in entries:
        answers = None if trees is None else trees[entry.file]
        job = Job(entry, answers, judging.made_from(dataset, entry, answers))
        kept = read_judgement(_path(workspace, entry), job.made_from)
        if kept is None:
            missing.append(job)
        else:
            found[entry.file] = kept
    for job, data in each_shape(judging, missing, workers, device):
        if isinstance(data, Crashed):
            raise InputError(job.entry.source, f"cannot be judged: {data.why}")
        text = json.dumps({"made_from": job.made_from, "judgement": data}, ensure_ascii=False)
        write_text_atomically(_path(workspace, job.entry), text + "\n")
        found[job.entry.file] = judgement_from_data(data)
        for failure in found[job.entry.file].failures:
            observer.note(f"failed: {failure}")
        observer.progress("evaluating shapes", len(found), len(entries), job.entry.id)
    return [found[entry.file] for entry in entries]


def _path(workspace: Workspace, entry: IndexEntry) -> Path:
    return workspace.evaluation / JUDGEMENTS / Path(entry.file).with_suffix(".json")


def read_judgement(path: Path, made_from: str) -> Judgement | None:
    """The judgement of a file; None if there is none, or it was made from something else."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        return judgement_from_data(data["judgement"]) if data["made_from"] == made_from else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def judgement_to_data(judgement: Judgement) -> dict[str, Any]:
    """A judgement as plain data."""
    return {
        "parts_given": {name: score_to_data(score) for name, score in judgement.parts_given.items()},
        "hierarchy_given": {name: score_to_data(score) for name, score in judgement.hierarchy_given.items()},
        "examples": [asdict(example) for example in judgement.examples],
        "failures": judgement.failures,
    }


def judgement_from_data(data: Mapping[str, Any]) -> Judgement:
    """What `judgement_to_data` took apart. Raises KeyError, TypeError, ValueError or AttributeError for anything else."""
    return Judgement(
        {name: score_from_data(score) for name, score in data["parts_given"].items()},
        {name: score_from_data(score) for name, score in data["hierarchy_given"].items()},
        [example_from_data(example) for example in data["examples"]],
        list(data["failures"]),
    )
