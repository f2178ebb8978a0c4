"""The HTML page of a workspace."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError, expecting
from kinmo.dataset.journal import runs
from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import IndexEntry, PreparedStore
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.evaluation.tables import Table as MeasuredTable
from kinmo.evaluation.tables import read_table
from kinmo.experiments.table1.evaluation_folder import ALL, EXAMPLES, PRINTED, SETTINGS, evaluations, is_current
from kinmo.experiments.table1.examples import Example, chosen, read_examples
from kinmo.io.atomic_files import write_text_atomically
from kinmo.learning.model_folder import METRICS, ModelFolder
from kinmo.methods import METHOD_MODELS
from kinmo.pipeline.label_acceptance import ACCEPTANCE, LABELLING
from kinmo.pipeline.prepare import REPORT
from kinmo.pipeline.score_urdfs import URDF_FILES
from kinmo.view.example_pictures import draw
from kinmo.view.report_page import Page, Picture, Section, Table, render
from kinmo.view.report_tables import shown
from kinmo.view.scan_sections import picture_sections, table_sections
from kinmo.view.training_curves import line_chart

PICTURES = 12
"""Of hits, and as many of failures, a method."""
PICTURED_TOGETHER = (("kinmo", None), ("OBB_fine", "GNN_fine"), ("GNN_fine", "GNN_coarse"))
"""Rows whose hits and failures are shown, and the row whose answer is drawn beside: what refining brings, and what fine types
do (the paper's figures 4, 6 and 3)."""
SECONDS_PER_PICTURE = 1.0
KEY = (
    "The moving part is blue. Types: R turns, P slides, PR does both; H or V for a horizontal or vertical axis; C or S for one "
    "near the part's centre or side. Then the angle to the true axis and, in diagonals, the distance from its line."
)


OUTDATED = (
    "Not shown: the evaluation was stopped, or networks, shapes or settings have changed since. The same kinmo eval gives "
    "the figures of what is there now."
)
RELABEL = " Networks were trained anew, or labelling was stopped, since: kinmo pseudo-label brings the labels up to date."


@dataclass(frozen=True)
class Report:
    """Write report/index.html about whatever the workspace holds."""

    workspace: Workspace

    def plan(self) -> Plan:
        wanted = 2 * len(PICTURED_TOGETHER) * min(PICTURES, len(self._examples()))
        return Plan((f"write {self._path}",), 1.0 + wanted * SECONDS_PER_PICTURE)

    def run(self, observer: Observer) -> Outcome:
        store = PreparedStore(self.workspace.prepared)
        sections = [
            self._runs(),
            self._data(store),
            *self._tables(),
            *table_sections(self.workspace),
            self._curves(),
            *self._pseudo_labels(),
            *self._pictures(store, observer),
            *picture_sections(self.workspace),
        ]
        facts = [("workspace", str(self.workspace.path.absolute())), ("prepared shapes", str(len(store)))]
        page = Page("kinmo report", facts, [section for section in sections if section is not None])
        write_text_atomically(self._path, render(page))
        return Outcome(self._path, {"report": str(self._path), "sections": [section.title for section in page.sections]})

    @property
    def _path(self) -> Path:
        return self.workspace.report / "index.html"

    def _runs(self) -> Section:
        rows = [
            (run.stage, run.what, run.started.replace("T", " ")[:19], f"{run.seconds:.1f}", run.kinmo)
            for run in runs(self.workspace)
        ]
        return Section("What was run", tables=[Table("Stages", ("stage", "what", "started (UTC)", "seconds", "kinmo"), rows)])

    def _data(self, store: PreparedStore) -> Section:
        counts = Counter((entry.category, _use(entry)) for entry in store.entries)
        uses = ("train", "validation", "test", "held back", "unlabelled")
        categories = sorted({entry.category for entry in store.entries})
        rows = [(name, *(str(counts[name, use]) for use in uses)) for name in categories]
        rows.append(("all", *(str(sum(counts[name, use] for name in categories)) for use in uses)))
        note = ""
        found = _json(self.workspace.prepared / REPORT)
        if found is not None:
            with expecting("the report of kinmo prepare", self.workspace.prepared / REPORT):
                note = (
                    ", ".join(f"{len(found[key])} {key.replace('_', ' ')}" for key in ("taken", "repaired", "left_out")) + "."
                )
        return Section("Data", tables=[Table("Prepared shapes by category and use", ("category", *uses), rows, note)])

    def _tables(self) -> Iterator[Section]:
        for name in evaluations(self.workspace):
            of = "" if name == ALL else f", {name}"
            if not is_current(self.workspace, name):
                yield Section(f"Table 1{of}", OUTDATED)
                continue
            for setting in SETTINGS:
                folder = self.workspace.evaluation / name / setting
                found = {path.stem: read_table(path) for path in sorted(folder.glob("*.json"))}
                more = [shown(table) for table_name, table in found.items() if table_name not in PRINTED]
                charts = [
                    chart
                    for table_name, table in found.items()
                    if table_name.startswith("label_truth")
                    for chart in _truth_charts(table_name, table)
                ]
                title = f"Table 1, {setting.replace('_', ' ')}{of}"
                yield Section(title, tables=[shown(found[printed]) for printed in PRINTED], charts=charts, more=more)
        files = sorted((self.workspace.evaluation / URDF_FILES).glob("*.json"))
        if files:
            yield Section("URDF files", tables=[shown(read_table(path)) for path in files])

    def _curves(self) -> Section | None:
        charts: list[str] = []
        for path in sorted(self.workspace.models.rglob(METRICS)):
            parts = path.parent.relative_to(self.workspace.models).parts
            name = " ".join(parts[1:] if parts[0] == "ancsh" else parts)  # the last part of a cell's folder says what it is
            with expecting("one entry an epoch", path):
                charts += _training_charts(name, _json(path) or [])
        charts = [chart for chart in charts if chart]
        return Section("Training", charts=charts) if charts else None

    def _pseudo_labels(self) -> Iterator[Section]:
        for method in METHOD_MODELS:
            workspace = self.workspace.by(method)
            report = _json(workspace.pseudo / ACCEPTANCE)
            if report is not None:
                with expecting("the report of kinmo pseudo-label", workspace.pseudo / ACCEPTANCE):
                    record = workspace.record(LABELLING)
                    text = report["text"] + (RELABEL if record is None or not self._labels_with(record) else "")
                    section = Section(f"Pseudo labels by {method}", text, [Table(**table) for table in report["tables"]])
                yield section

    def _labels_with(self, record: StageRecord) -> bool:
        """Whether the networks that gave labels are those that the workspace has now."""
        models = METHOD_MODELS.get(str(record.inputs.get("method")), ())
        return bool(record.inputs.get("weights") == ModelFolder(self.workspace.motion.models).digest(models))

    def _pictures(self, store: PreparedStore, observer: Observer) -> Iterator[Section]:
        examples = self._examples()
        for row, beside in PICTURED_TOGETHER:
            answered = [example for example in examples if row in example.answers]
            for title, wanted in ((f"{row}: right", True), (f"{row}: wrong", False)):
                some = chosen((e for e in answered if e.answers[row].is_ok is wanted), PICTURES)
                pictures = list(self._draw_all(store, some, row, beside, title, observer))
                if pictures:
                    legend = [("truth", "true axis"), ("refined", row), *([("network", beside)] if beside else [])]
                    yield Section(title, _explained(wanted, len(some), answered, row), pictures=pictures, legend=legend)

    def _examples(self) -> list[Example]:
        return read_examples(self.workspace.evaluation / ALL / EXAMPLES) if is_current(self.workspace, ALL) else []

    def _draw_all(
        self, store: PreparedStore, examples: Sequence[Example], row: str, beside: str | None, what: str, observer: Observer
    ) -> Iterator[Picture]:
        for done, example in enumerate(examples):
            roles = {"refined": row} | ({"network": beside} if beside else {})
            try:
                svg = draw(store, example, roles)
            except InputError as error:
                observer.note(f"no picture of {example.shape_id}: {error}")
                continue
            lines = [f"{example.name}: {example.true_type}", *(f"{n}: {example.answers[n].text}" for n in roles.values())]
            yield Picture(svg, f"{example.category} {example.shape_id}", lines)
            observer.progress(f"drawing {what}", done + 1, len(examples), example.shape_id)


def _use(entry: IndexEntry) -> str:
    """What a prepared shape is for."""
    if not entry.is_labelled:
        return "unlabelled"
    split = split_of(entry.id)
    return "held back" if entry.is_held_back and split is not Split.TEST else split.value


def _training_charts(name: str, history: Sequence[Mapping[str, float]]) -> list[str]:
    """The losses of a network over the epochs, and by what it was judged on validation."""
    loss = {kind: _series(history, f"{kind}/loss") for kind in ("training", "validation")}
    names = [key for key in (history[-1] if history else {}) if key.startswith("validation/") and not key.endswith("loss")]
    errors = {key.split("/")[1].replace("_", " "): _series(history, key) for key in names}
    return [line_chart(f"{name}: loss", loss, "epoch"), line_chart(f"{name}: validation", errors, "epoch")]


def _truth_charts(name: str, table: MeasuredTable) -> Iterator[str]:
    """Precision and recall of pseudo labels over the threshold, one line a way of scoring."""
    titles = [column.title for column in table.columns]
    for figure in ("precision", "recall"):
        series: dict[str, list[tuple[float, float]]] = {}
        for row in table.rows:
            cells = dict(zip(titles, row, strict=True))
            tau, value = cells["tau"], cells[figure]
            if isinstance(tau, float | int) and isinstance(value, float | int):
                series.setdefault(str(cells["score"]), []).append((tau, value))
        if series:
            yield line_chart(f"{name.removeprefix('label_truth_')} as labels: {figure}", series, "threshold")


def _explained(right: bool, shown: int, answered: Sequence[Example], row: str) -> str:
    count = sum(example.answers[row].is_ok is right for example in answered)
    total = f"{count} of {len(answered)} true joints of the test shapes, parts given"
    return f"{total}; {shown} are shown, by category in turn. {KEY}"


def _series(history: Sequence[Mapping[str, float]], key: str) -> list[tuple[float, float]]:
    return [(row["epoch"], row[key]) for row in history if key in row]


def _json(path: Path) -> Any:
    """The content of a JSON file; None if there is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError:
        return None
    except ValueError as error:
        raise InputError(path, f"expected JSON ({error})") from error
