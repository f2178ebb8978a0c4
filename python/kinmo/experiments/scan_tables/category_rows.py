"""Rows of a table of scans for one category, with the scores that there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from kinmo.core.errors import InputError
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_records import read_scores
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN, OUTDATED, ScanRow
from kinmo.experiments.scan_tables.table_rows import TABLES, TableRow, printed_row
from kinmo.learning.model_folder import trained_on
from kinmo.pipeline.scans.scan_dataset import open_scan_dataset
from kinmo.pipeline.scans.scan_scores import Protocol, ScanScores

InputsBySeed = Mapping[int, Mapping[str, dict[str, Any] | None]]
"""Inputs of up-to-date scores by seed and title of the row; None for scores that are missing or outdated."""


def current_scores(workspace: Workspace, name: str, category: str, seeds: Sequence[int]) -> InputsBySeed:
    """Inputs of all up-to-date scores of a table for a category.

    Scores of objects with another structure than those in the original workspace cannot stand beside the others: they count as
    outdated.
    """
    structure: str | None = None
    with suppress(InputError):
        structure = str(open_scan_dataset(workspace, category).structure)

    def inputs(row: TableRow, seed: int) -> dict[str, Any] | None:
        found = row.scores(workspace, category, seed).current_inputs()
        return found if found is not None and found["structure"] == structure else None

    return {seed: {row.title: inputs(row, seed) for row in TABLES[name].rows} for seed in seeds}


@dataclass(frozen=True)
class CategoryRows:
    """Rows of the table `name` for one category, from the scores in the original workspace whose `inputs` are up to date."""

    workspace: Workspace
    name: str
    category: str
    inputs: InputsBySeed
    protocol: Protocol

    def row(self, row: TableRow) -> ScanRow:
        """One row of the table; a missing or outdated one says so."""
        scores = {seed: row.scores(self.workspace, self.category, seed) for seed in self.inputs}
        seeds = tuple(seed for seed, known in self.inputs.items() if known[row.title] is not None)
        objects = tuple(read_scores([scores[seed].path(self.protocol) for seed in seeds]))
        is_outdated = any(own.path(self.protocol).exists() for own in scores.values())
        return ScanRow(
            row.title,
            objects,
            printed_row(self.name, self.category, row.printed),
            seeds,
            OUTDATED if is_outdated else NOT_RUN,
            self._trained_on(row, seeds),
            self._reason([scores[seed] for seed in self.inputs if seed not in seeds]),
        )

    def comparable(self, titles: Sequence[str]) -> list[ScanRow]:
        """Rows of some titles over the seeds that all of them have; none if there is no such seed."""
        rows = {row.title: row for row in TABLES[self.name].rows}
        shared = {seed: known for seed, known in self.inputs.items() if all(known.get(title) for title in titles)}
        return [replace(self, inputs=shared).row(rows[title]) for title in titles] if shared else []

    def by_seed(self) -> list[CategoryRows]:
        """The same rows, one seed at a time."""
        return [replace(self, inputs={seed: known}) for seed, known in self.inputs.items()]

    def _reason(self, missing: Sequence[ScanScores]) -> str | None:
        """Recorded reasons why scores are missing."""
        seeds: dict[str, list[str]] = {}
        for scores in missing:
            if not scores.path(self.protocol).exists() and (reason := scores.reason()):
                seeds.setdefault(reason, []).append(str(scores.run.seed))
        whole = len(self.inputs)
        texts = (reason if len(own) == whole else f"seeds {', '.join(own)}: {reason}" for reason, own in seeds.items())
        return "; ".join(texts) or None

    def _trained_on(self, row: TableRow, seeds: Sequence[int]) -> str | None:
        """Numbers of labelled and of other training objects; several pairs if they differ between seeds."""
        place = row.variant.workspace(self.workspace)
        pairs = (row.run(self.category, seed).weights(place) for seed in seeds)
        counts = dict.fromkeys(trained_on(weights[0]) for weights in pairs if weights)
        return " or ".join(f"{labelled} + {others}" if others else str(labelled) for labelled, others in counts) or None
