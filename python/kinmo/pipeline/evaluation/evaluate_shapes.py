"""The stage `eval` for shapes: Table 1 on the test shapes of a workspace, in both settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from kinmo.core.errors import InputError
from kinmo.dataset.cache import Cache, cache_key
from kinmo.dataset.jobs import Failure
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import ShapeDataset, open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, read_prepared
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.shape_tables import Rows, Scores, category_tables, overviews, summary_table
from kinmo.evaluation.tables import Caption, Table, as_text, read_table, write_table
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.io.atomic_files import remove_leftovers, write_folder_atomically, write_json_atomically, write_text_atomically
from kinmo.io.discover import ShapeSource
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.evaluation.evaluation_folder import (
    EXAMPLES,
    PRINTED_TABLES,
    SETTINGS,
    SHAPE_SCORES,
    SUMMARIES,
    EvaluationFolder,
    test_shapes,
    workspace_inputs,
)
from kinmo.pipeline.evaluation.example_predictions import write_examples
from kinmo.pipeline.evaluation.method_rows import Row, method_rows
from kinmo.pipeline.evaluation.shape_evaluation import Baselines, ShapeScores, evaluate_shape
from kinmo.pipeline.network_jobs import network_runner

SECONDS_PER_SHAPE = 2.0  # first estimate, for one CPU core

MoreTables = Callable[[Rows, Caption], Mapping[str, Table]]
"""Function of all scores of a setting and a caption that returns further tables by name."""


class MoreRows(Protocol):
    """Rows beside those of the methods, such as ablations."""

    def __call__(self, models: ModelFolder, rows: Sequence[Row], device: str) -> list[Row]:
        """Further rows, from the trained networks, the rows so far, and the device where networks run."""

    def missing(self, rows: Sequence[Row]) -> str:
        """Sentence about rows that were asked for but have no networks, given all rows; empty if there are none."""


@dataclass(frozen=True)
class EvaluateShapes:
    """Score the trained methods on the test shapes of a workspace, and write Table 1."""

    workspace: Workspace
    methods: tuple[str, ...] = tuple(METHOD_MODELS)  # `kinmo`, `paper` or both
    category: str | None = None
    baselines: Baselines | None = None
    more_rows: MoreRows | None = None
    more_tables: MoreTables | None = None
    device: str = "auto"
    workers: int = 1
    details: bool = False  # print all figures

    def plan(self) -> Plan:
        """Nothing, if the tables are up to date."""
        dataset, rows = open_dataset(self.workspace, self.category), self._rows()
        folder = EvaluationFolder(self.workspace, dataset.category)
        if self._is_current(folder.stage, self._inputs(dataset.category, rows)):
            return Plan((), 0.0)
        count = len(test_shapes(dataset))
        step = f"score {len(rows)} rows on {count} test shapes, parts given and hierarchy given"
        each = seconds_per_unit(self.workspace, folder.stage, SECONDS_PER_SHAPE / self.workers)
        return Plan((step,), count * each)

    def run(self, observer: Observer) -> Outcome:
        """Score what is not up to date, and write the tables."""
        dataset, rows = open_dataset(self.workspace, self.category), self._rows()
        folder = EvaluationFolder(self.workspace, dataset.category)
        with self.workspace.locked():
            inputs = self._inputs(dataset.category, rows)
            if self._is_current(folder.stage, inputs):
                observer.note("already evaluated")
                return _outcome(folder.path, self.details)
            self.workspace.forget(folder.stage)
            remove_leftovers(self.workspace.evaluation)
            missing = self.more_rows.missing(rows) if self.more_rows else ""
            if missing:
                observer.note(missing)
            with timed(self.workspace, folder.stage) as watch:
                scored = self._scores(dataset, rows, observer)
                with write_folder_atomically(folder.path) as draft:
                    self._write(draft, scored, dataset.category, self._models.seeds(_models_of(rows)), missing)
                watch.amount, watch.what = len(scored), f"{len(rows)} rows on {len(scored)} test shapes"
            self.workspace.record(folder.stage, inputs, sorted(path for path in folder.path.rglob("*") if path.is_file()))
        return _outcome(folder.path, self.details)

    @property
    def _models(self) -> ModelFolder:
        return ModelFolder(self.workspace.models)

    def _rows(self) -> list[Row]:
        rows = method_rows(self._models, self.methods, self.device)
        return rows + (self.more_rows(self._models, rows, self.device) if self.more_rows else [])

    def _inputs(self, category: str | None, rows: Sequence[Row]) -> dict[str, Any]:
        """Everything that the tables depend on."""
        own = {"rows": _settings(rows), "baselines": self._baseline_settings, "tables": self.more_tables is not None}
        return workspace_inputs(self.workspace, category, _models_of(rows)) | own

    def _is_current(self, stage: str, inputs: dict[str, Any]) -> bool:
        """True if the tables are up to date. They may have baselines and further tables that this evaluation does not add."""
        recorded = self.workspace.inputs_of(stage) or {}
        extra = {name: recorded.get(name) for name in ("baselines", "tables") if not inputs[name]}
        return self.workspace.is_current(stage, inputs | extra)

    @property
    def _baseline_settings(self) -> dict[str, Any] | None:
        return dict(self.baselines.settings) if self.baselines else None

    def _scores(self, dataset: ShapeDataset, rows: Sequence[Row], observer: Observer) -> list[ShapeScores]:
        """Scores of all test shapes; those that are up to date are read."""
        entries = test_shapes(dataset)
        baselines = self.baselines.prepare(self.workspace, observer) if self.baselines else {}
        settings = [_settings(rows), self._baseline_settings]
        cache = Cache(self.workspace.evaluation / SHAPE_SCORES)
        found: dict[str, ShapeScores] = {}
        jobs = []
        for entry in entries:
            data = baselines.get(entry.file)
            key = cache_key(shape=entry.key, settings=settings, baselines=data)
            job = ScoreJob(entry, data, cache.folder / f"{Path(entry.file).stem}-{entry.layout}.json", key)
            if cache.is_current(job.path.stem, key):
                found[entry.file] = ShapeScores.from_data(json.loads(job.path.read_text(encoding="utf-8")))
            else:
                jobs.append(job)
        scorer = ShapeScorer(dataset.store.folder, tuple(rows), self.baselines)
        runner = network_runner(self.workers, self.device)
        with closing(runner.run(scorer, jobs)) as finished:  # no job outlives the lock
            for job, scored in finished:
                if isinstance(scored, Failure):
                    raise InputError(job.entry.source, f"cannot be evaluated: {scored.reason}")
                write_text_atomically(job.path, json.dumps(scored, ensure_ascii=False) + "\n")
                cache.store(job.path.stem, job.key, [job.path])
                found[job.entry.file] = ShapeScores.from_data(scored)
                for failure in found[job.entry.file].failures:
                    observer.note(f"failed: {failure}")
                observer.progress("evaluating shapes", len(found), len(entries), job.entry.id)
        return [found[entry.file] for entry in entries]

    def _write(
        self, folder: Path, scored: Sequence[ShapeScores], category: str | None, seeds: tuple[int, ...], note: str
    ) -> None:
        """Write all tables, summaries and examples. `seeds` of the networks and `note` go below the tables."""
        if failures := sum(len(scores.failures) for scores in scored):
            note = f"{failures} predictions failed and count as missed. {note}".rstrip()
        data = f"{category or 'all categories'} of workspace {self.workspace.path.absolute().name}"
        for setting in SETTINGS:
            title = f"Table 1, {setting.replace('_', ' ')}"
            caption = Caption(title, data, 0, 0, "test split by hashed id", seeds, note)
            scores = _by_row(scored, setting)
            headline = {name: own for name, own in scores.items() if "," not in name}  # ablations have a comma
            tables = {"summary": summary_table(scores, caption)} | overviews(scores, caption)
            tables |= category_tables(headline, caption, whole=category is None)
            tables |= self.more_tables(scores, caption) if self.more_tables else {}
            for name, table in tables.items():
                write_table(table, folder / setting, name)
            summaries = {name: own.summary.to_json() for name, own in scores.items()}
            write_json_atomically(folder / SUMMARIES / f"{setting}.json", summaries)
        write_examples(folder / EXAMPLES, (example for scores in scored for example in scores.examples))


@dataclass(frozen=True)
class ScoreJob:
    """One test shape to score into the file `path`, with the baselines' data for it and the cache key."""

    entry: IndexEntry
    baselines: Any
    path: Path
    key: str


@dataclass(frozen=True)
class ShapeScorer:
    """Scores shapes by some rows, in any process; `store` is the folder of the prepared shapes."""

    store: Path
    rows: tuple[Row, ...]
    baselines: Baselines | None

    def __call__(self, job: ScoreJob) -> dict[str, Any]:
        """Scores of a shape as plain data."""
        truth = read_prepared(self.store / job.entry.file)
        meshes = leaf_meshes(ShapeSource.of(job.entry).read(), truth)
        first = self.baselines.score(truth, meshes, job.baselines) if self.baselines else ({}, {})
        return evaluate_shape(truth, meshes, job.entry.layout, self.rows, first).to_data()


def _models_of(rows: Sequence[Row]) -> tuple[str, ...]:
    """Models that the rows use, sorted."""
    return tuple(sorted({model for row in rows for model in row.method.model_names}))


def _settings(rows: Sequence[Row]) -> dict[str, Any]:
    """Everything that the rows' predictions depend on."""
    return {row.name: [row.method.weights, dict(row.method.config)] for row in rows}


def _by_row(scored: Sequence[ShapeScores], setting: str) -> Rows:
    """Scores of all shapes in one setting, by row."""
    scores: dict[str, list[ShapeScore]] = {}
    for own in scored:
        for name, score in getattr(own, setting).items():
            scores.setdefault(name, []).append(score)
    return {name: Scores(shapes) for name, shapes in scores.items()}


def _outcome(folder: Path, details: bool) -> Outcome:
    tables = {
        setting: {path.stem: read_table(path) for path in sorted((folder / setting).glob("*.json"))} for setting in SETTINGS
    }
    if details:
        text = "\n".join(as_text(own[name]) for own in tables.values() for name in PRINTED_TABLES)
    else:
        text = "\n".join(as_text(own["summary"]) for own in tables.values())
        text += "\nEvery figure of every row: --details, and the tables (JSON, CSV, Markdown, LaTeX) in the folder below."
    data = {setting: {name: _plain(table) for name, table in own.items()} for setting, own in tables.items()}
    return Outcome(folder, data, text)


def _plain(table: Table) -> dict[str, Any]:
    columns = [column.title for column in table.columns]
    return {"caption": str(table.caption), "columns": columns, "rows": [list(row) for row in table.rows]}
