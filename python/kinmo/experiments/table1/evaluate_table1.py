"""Table 1 on the test shapes of a workspace, in both settings."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import StageRecord, Workspace
from kinmo.evaluation.joint_records import ShapeScore
from kinmo.evaluation.tables import Caption, Table, as_text, read_table, write_table
from kinmo.experiments.label_truth import RANKING_WEIGHTS, WEIGHTS, curves, label_truth_table
from kinmo.experiments.table1.evaluation_folder import (
    EXAMPLES,
    PRINTED,
    SETTINGS,
    SUMMARIES,
    Choice,
    folder_of,
    made_from,
    stage_of,
    test_shapes,
)
from kinmo.experiments.table1.examples import write_examples
from kinmo.experiments.table1.kept_scores import Judge, judgements
from kinmo.experiments.table1.rows import CONTACT_EDGES, Row, chosen_rows
from kinmo.experiments.table1.shape_scores import Judgement
from kinmo.experiments.table1.table1_tables import Rows, Scores, caption_for, category_tables, overviews
from kinmo.experiments.table1.trees_answers import trees_answers
from kinmo.io.atomic_files import remove_leftovers, write_text_atomically
from kinmo.io.writers.whole_folder import whole_folder
from kinmo.learning.model_folder import ModelFolder

LABELLERS = {"kinmo": RANKING_WEIGHTS, "OBB_fine": WEIGHTS}
"""Rows that make pseudo labels, and the ways of scoring that are held against the truth."""
SECONDS_PER_SHAPE = 2.0
"""On one core, until the journal knows better."""


@dataclass(frozen=True)
class Evaluate:
    """Score the trained networks on the test shapes, all or those of one category.

    `methods` says whose rows are wanted; `ablations` adds the rows of other candidates, terms and edges, `hidden_names` those
    with all part names hidden. The rows that frame the table are always there; of them `trees` needs scikit-learn.
    """

    workspace: Workspace
    methods: tuple[str, ...]
    category: str | None = None
    ablations: bool = False
    hidden_names: bool = False
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        choice, rows = self._choice(), self._rows()
        if self.workspace.is_current(stage_of(choice.name), made_from(self.workspace, choice)):
            return Plan((), 0.0)
        count = len(test_shapes(open_dataset(self.workspace, choice.category)))
        step = f"score {len(rows)} rows on {count} test shapes, parts given and hierarchy given"
        each = seconds_per_unit(self.workspace, stage_of(choice.name), SECONDS_PER_SHAPE / self.workers)
        return Plan((step,), count * each)

    def run(self, observer: Observer) -> Outcome:
        choice, rows = self._choice(), self._rows()
        stage, folder = stage_of(choice.name), folder_of(self.workspace, choice.name)
        with self.workspace.locked():
            inputs = made_from(self.workspace, choice)
            if self.workspace.is_current(stage, inputs):
                observer.note("evaluated already")
            else:
                self.workspace.forget(stage)
                remove_leftovers(self.workspace.evaluation)
                with timed(self.workspace, stage) as watch:
                    judged = self._judge(choice, rows, observer)
                    with whole_folder(folder) as draft:
                        self._write(draft, judged, choice, self._left_out(rows, observer))
                    watch.amount, watch.what = len(judged), f"{len(rows)} rows on {len(judged)} test shapes"
                written = sorted(path for path in folder.rglob("*") if path.is_file())
                outputs = tuple(str(path.relative_to(self.workspace.path)) for path in written)
                self.workspace.write_record(stage, StageRecord(inputs, outputs))
        return _outcome(folder)

    def _choice(self) -> Choice:
        category = open_dataset(self.workspace, self.category).category
        return Choice(self.methods, category, self.ablations, self.hidden_names, self.seed)

    def _rows(self) -> list[Row]:
        return chosen_rows(self.workspace, self.methods, self.device, self.ablations, self.hidden_names)

    def _judge(self, choice: Choice, rows: Sequence[Row], observer: Observer) -> list[Judgement]:
        dataset = open_dataset(self.workspace, choice.category)
        judging = Judge(dataset.store.folder, tuple(rows), ModelFolder(self.workspace.motion.models).config().refinement)
        trees = trees_answers(self.workspace, self.seed, observer)
        return judgements(self.workspace, dataset, test_shapes(dataset), judging, trees, self.workers, self.device, observer)

    def _left_out(self, rows: Sequence[Row], observer: Observer) -> str:
        """What was asked for and is not in the tables."""
        if not (self.ablations and "paper" in self.methods) or any(row.name == CONTACT_EDGES for row in rows):
            return ""
        observer.note("no rows of contact edges: their network is trained by kinmo train contact-edges")
        return "No rows of contact edges: their network was not trained."

    def _write(self, folder: Path, judged: Sequence[Judgement], choice: Choice, left_out: str) -> None:
        failures = sum(len(judgement.failures) for judgement in judged)
        note = " ".join(filter(None, [f"{failures} predictions failed and count as missed." if failures else "", left_out]))
        seeds = ModelFolder(self.workspace.motion.models).seeds(choice.models)
        data = f"{choice.category or 'all categories'} of workspace {self.workspace.path.absolute().name}"
        for setting in SETTINGS:
            caption = Caption(f"Table 1, {_words(setting)}", data, 0, 0, "test split by hashed id", seeds, note)
            scores = _scores(judged, setting)
            for name, table in _tables(scores, setting, caption, whole=choice.category is None).items():
                write_table(table, folder / setting, name)
            found = {name: row.summary.to_json() for name, row in scores.items()}
            write_text_atomically(
                folder / SUMMARIES / f"{setting}.json", json.dumps(found, indent=1, ensure_ascii=False) + "\n"
            )
        write_examples(folder / EXAMPLES, (example for judgement in judged for example in judgement.examples))


def _outcome(folder: Path) -> Outcome:
    tables = {
        setting: {path.stem: read_table(path) for path in sorted((folder / setting).glob("*.json"))} for setting in SETTINGS
    }
    text = "\n".join(as_text(found[name]) for found in tables.values() for name in PRINTED)
    data = {setting: {name: _plain(table) for name, table in found.items()} for setting, found in tables.items()}
    return Outcome(folder, data, text)


def _tables(scores: Rows, setting: str, caption: Caption, *, whole: bool) -> Mapping[str, Table]:
    """All tables of one setting, of all categories or of one.

    Those by category have no columns for ablations, whose names hold a comma.
    """
    headline = {name: found for name, found in scores.items() if "," not in name}
    tables = overviews(scores, caption) | category_tables(headline, caption, whole=whole)
    for name, ways in LABELLERS.items():
        if name in scores:
            title = replace(
                caption_for(scores[name].shapes, caption), title=f"Truth of the labels of {name}, {_words(setting)}"
            )
            tables[f"label_truth_{name}"] = label_truth_table(curves(scores[name].shapes, weights=ways), title)
    return tables


def _scores(judged: Sequence[Judgement], setting: str) -> Rows:
    """The scores of all shapes in one setting, by row."""
    scores: dict[str, list[ShapeScore]] = {}
    for judgement in judged:
        for name, score in getattr(judgement, setting).items():
            scores.setdefault(name, []).append(score)
    return {name: Scores(shapes) for name, shapes in scores.items()}


def _words(setting: str) -> str:
    return setting.replace("_", " ")


def _plain(table: Table) -> dict[str, Any]:
    return {
        "caption": str(table.caption),
        "columns": [c.title for c in table.columns],
        "rows": [list(row) for row in table.rows],
    }
