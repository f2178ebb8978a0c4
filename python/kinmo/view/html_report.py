"""The stage `report`: one HTML page about a workspace."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError, expecting
from kinmo.core.wording import counted
from kinmo.dataset.journal import runs
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.tables import Table as FigureTable
from kinmo.evaluation.tables import read_table
from kinmo.io.atomic_files import write_text_atomically
from kinmo.learning.model_folder import METRICS, ModelFolder
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.evaluation.evaluation_folder import (
    EXAMPLES,
    PRINTED_TABLES,
    SETTINGS,
    EvaluationFolder,
    evaluation_folders,
)
from kinmo.pipeline.evaluation.example_predictions import Example, read_examples, spread_over_categories
from kinmo.pipeline.prepare_shapes import REPORT
from kinmo.pipeline.pseudo_label_files import REPORT as ACCEPTANCE
from kinmo.pipeline.pseudo_label_files import labels_folder, stage_of
from kinmo.pipeline.scans.scan_networks import MODEL as SCAN_MODELS
from kinmo.pipeline.score_urdfs import URDF_FILES
from kinmo.view.example_shape import example_scene, example_shape
from kinmo.view.report_page import Page, Picture, Section, Table, render
from kinmo.view.scan_sections import picture_sections, table_sections
from kinmo.view.scene_data import scene_json
from kinmo.view.shape_picture import draw_example
from kinmo.view.training_curves import line_chart

MAX_PICTURES = 12  # pictures of right predictions, and of wrong ones, for each row
PICTURED_TOGETHER = (("kinmo", None), ("OBB_fine", "GNN_fine"), ("GNN_fine", "GNN_coarse"))
"""Rows with pictures, and the row drawn beside: the effect of refinement and of fine types (the paper's figures 4, 6, 3)."""
SECONDS_PER_PICTURE = 1.0
MAX_SCENE_BYTES = 32 << 20
"""Largest size of all objects that the page shows in 3D."""
KEY = (
    "The moving part is blue. Types: R turns, P slides, PR does both; H or V for a horizontal or vertical axis; C or S for an "
    "axis near the part's centre or side. Then the angle to the true axis and the distance from its line in diagonals."
)
OUTDATED = (
    "Not shown: the evaluation was interrupted, or networks, shapes or settings have changed since. Run the same kinmo eval "
    "again."
)
RELABEL = " The networks have changed since, or labelling was interrupted: run kinmo pseudo-label to update the labels."


@dataclass
class SceneBudget:
    """Bytes that are left for objects in 3D. Objects that do not fit are counted."""

    left: int = MAX_SCENE_BYTES
    left_out: int = 0

    def take(self, scene: str) -> str:
        """The scene, or nothing if there is no space for it."""
        if len(scene) > self.left:
            self.left_out += 1
            return ""
        self.left -= len(scene)
        return scene

    def note(self) -> str:
        """A sentence about the objects that did not fit since the last note."""
        count, self.left_out = self.left_out, 0
        limit = MAX_SCENE_BYTES >> 20
        return f"{count} of them without 3D, as all objects together would take more than {limit} MiB. " if count else ""


@dataclass(frozen=True)
class Report:
    """Write report/index.html about everything that a workspace holds: pictures, summaries, then folded details."""

    workspace: Workspace

    def plan(self) -> Plan:
        """The page, with an estimate for its pictures."""
        PreparedStore(self.workspace.prepared)  # raises if nothing is prepared
        wanted = 2 * len(PICTURED_TOGETHER) * min(MAX_PICTURES, len(self._examples()))
        return Plan((f"write {self._path}",), 1.0 + wanted * SECONDS_PER_PICTURE)

    def run(self, observer: Observer) -> Outcome:
        """Write the page."""
        store = PreparedStore(self.workspace.prepared)
        tables = [*self._tables(), *table_sections(self.workspace)]
        details = [self._data(store), *self._pseudo_labels(), *self._curves(), self._runs()]
        sections = [
            *self._pictures(store, observer),
            *picture_sections(self.workspace),
            *tables,
            *(replace(section, is_folded=True) for section in details),
        ]
        facts = [("workspace", str(self.workspace.path.absolute())), ("prepared shapes", str(len(store)))]
        page = Page("kinmo report", facts, sections)
        write_text_atomically(self._path, render(page))
        return Outcome(self._path, {"report": str(self._path), "sections": [section.title for section in page.sections]})

    @property
    def _path(self) -> Path:
        return self.workspace.report / "index.html"

    def _runs(self) -> Section:
        found = ((run, run.started.replace("T", " ")[:19]) for run in runs(self.workspace))
        rows = [(run.stage, run.what, started, f"{run.seconds:.1f}", run.kinmo) for run, started in found]
        return Section("Runs", tables=[Table("Stages", ("stage", "what", "started (UTC)", "seconds", "kinmo"), rows)])

    def _data(self, store: PreparedStore) -> Section:
        counts = Counter((entry.category, _use(entry)) for entry in store.entries)
        uses = ("train", "validation", "test", "oracle", "unlabelled")
        categories = sorted({entry.category for entry in store.entries})
        rows = [(name, *(str(counts[name, use]) for use in uses)) for name in categories]
        rows.append(("all", *(str(sum(counts[name, use] for name in categories)) for use in uses)))
        note = ""
        found = _json(self.workspace.prepared / REPORT)
        if found is not None:
            with expecting("the report of kinmo prepare", self.workspace.prepared / REPORT):
                note = ", ".join(f"{len(found[key])} {key}" for key in ("included", "repaired", "skipped")) + "."
        return Section("Data", tables=[Table("Prepared shapes by category and use", ("category", *uses), rows, note)])

    def _tables(self) -> Iterator[Section]:
        categories = tuple(sorted({entry.category for entry in PreparedStore(self.workspace.prepared).entries} - {""}))
        for evaluated in evaluation_folders(self.workspace, categories):
            of = "" if evaluated.category is None else f", {evaluated.category}"
            if not evaluated.is_current:
                yield Section(f"Table 1{of}", OUTDATED)
                continue
            for setting in SETTINGS:
                found = {path.stem: read_table(path) for path in sorted((evaluated.path / setting).glob("*.json"))}
                more = [*PRINTED_TABLES, *(name for name in found if name not in (*PRINTED_TABLES, "summary"))]
                labels = [(name, table) for name, table in found.items() if name.startswith("label_truth")]
                charts = [chart for name, table in labels for chart in _truth_charts(name, table)]
                title = f"Table 1, {setting.replace('_', ' ')}{of}"
                summary = [Table.of(found["summary"])]
                yield Section(title, tables=summary, charts=charts, more=[Table.of(found[name]) for name in more])
        files = sorted((self.workspace.evaluation / URDF_FILES).glob("*.json"))
        if files:
            yield Section("URDF files", tables=[Table.of(read_table(path)) for path in files])

    def _curves(self) -> Iterator[Section]:
        charts: list[str] = []
        for path in sorted(self.workspace.models.rglob(METRICS)):
            parts = path.parent.relative_to(self.workspace.models).parts
            name = " ".join(parts[1:] if parts[0] == SCAN_MODELS else parts)
            with expecting("one entry per epoch", path):
                charts += filter(None, _training_charts(name, _json(path) or []))
        if charts:
            yield Section("Training", charts=charts)

    def _pseudo_labels(self) -> Iterator[Section]:
        for method, models in METHOD_MODELS.items():
            path = labels_folder(self.workspace, method) / ACCEPTANCE
            report = _json(path)
            if report is not None:
                with expecting("the report of kinmo pseudo-label", path):
                    inputs = self.workspace.inputs_of(stage_of(method)) or {}
                    is_current = inputs.get("weights") == ModelFolder(self.workspace.models).digest(models)
                    text = report["text"] + ("" if is_current else RELABEL)
                    yield Section(f"Pseudo labels by {method}", text, [Table(**table) for table in report["tables"]])

    def _pictures(self, store: PreparedStore, observer: Observer) -> Iterator[Section]:
        examples = self._examples()
        key, budget = KEY, SceneBudget()
        for row, beside in PICTURED_TOGETHER:
            predicted = [example for example in examples if row in example.predictions]
            roles = {"refined": row} | ({"network": beside} if beside else {})
            for title, wanted in ((f"{row}: right", True), (f"{row}: wrong", False)):
                own = [example for example in predicted if example.predictions[row].is_ok is wanted]
                pictures = list(self._draw(store, spread_over_categories(own, MAX_PICTURES), roles, title, budget, observer))
                if pictures:
                    legend = [("truth", "true axis"), *roles.items()]
                    counts = f"{len(own)} of {len(predicted)} true joints of the test shapes, parts given"
                    text = f"{counts}; {counted(len(pictures), 'picture')}, by category in turn. {budget.note()}{key}".rstrip()
                    yield Section(title, text, pictures=pictures, legend=legend)
                    key = ""

    def _examples(self) -> list[Example]:
        evaluated = EvaluationFolder(self.workspace)
        return read_examples(evaluated.path / EXAMPLES) if evaluated.is_current else []

    def _draw(
        self,
        store: PreparedStore,
        examples: Sequence[Example],
        roles: Mapping[str, str],
        what: str,
        budget: SceneBudget,
        observer: Observer,
    ) -> Iterator[Picture]:
        for done, example in enumerate(examples):
            try:
                svg = draw_example(store, example, roles)
                rows = {row: row for row in roles.values()}
                scene = budget.take(scene_json(example_scene(example_shape(store, example), example, rows)))
            except InputError as error:
                observer.note(f"no picture of {example.shape_id}: {error}")
                continue
            lines = [f"{example.name}: {example.true_type}"]
            lines += [f"{name}: {example.predictions[name].text}" for name in roles.values()]
            yield Picture(svg, f"{example.category} {example.shape_id}", lines, scene)
            observer.progress(f"drawing {what}", done + 1, len(examples), example.shape_id)


def _use(entry: IndexEntry) -> str:
    if not entry.is_labelled:
        return "unlabelled"
    split = split_of(entry.id)
    return "oracle" if entry.is_oracle and split is not Split.TEST else split.value


def _training_charts(name: str, history: Sequence[Mapping[str, float]]) -> list[str]:
    """Charts of the losses, and of the validation errors, over the epochs."""
    loss = {kind: _series(history, f"{kind}/loss") for kind in ("training", "validation")}
    names = [key for key in (history[-1] if history else {}) if key.startswith("validation/") and not key.endswith("loss")]
    errors = {key.split("/")[1].replace("_", " "): _series(history, key) for key in names}
    return [line_chart(f"{name}: loss", loss, "epoch"), line_chart(f"{name}: validation", errors, "epoch")]


def _truth_charts(name: str, table: FigureTable) -> Iterator[str]:
    """Charts of precision and recall of pseudo labels over the threshold, one line for each score."""
    titles = [column.title for column in table.columns]
    rows = [dict(zip(titles, row, strict=True)) for row in table.rows]
    for figure in ("precision", "recall"):
        series: dict[str, list[tuple[float, float]]] = {}
        for cells in rows:
            tau, value = cells["tau"], cells[figure]
            if isinstance(tau, float | int) and isinstance(value, float | int):
                series.setdefault(str(cells["score"]), []).append((tau, value))
        if series:
            yield line_chart(f"{name.removeprefix('label_truth_')} as labels: {figure}", series, "threshold")


def _series(history: Sequence[Mapping[str, float]], key: str) -> list[tuple[float, float]]:
    return [(row["epoch"], row[key]) for row in history if key in row]


def _json(path: Path) -> Any:
    """Contents of a JSON file; None if there is no file."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        return None
    except ValueError as error:
        raise InputError(path, f"expected JSON ({error}): remove the file") from error
