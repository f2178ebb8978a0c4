"""The rows of Table 2, 3 or 4 of one category, of whatever was judged."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.scan_records import read_scores
from kinmo.experiments.scan_tables.scan_table_layout import NOT_RUN, OUTDATED, ScanRow
from kinmo.experiments.scan_tables.table_rows import TABLES, RowOf, printed_row
from kinmo.learning.model_folder import trained_on
from kinmo.pipeline.scans.scan_networks import Protocol
from kinmo.pipeline.scans.scored_scans import JudgedScans

HeldBySeed = Mapping[int, Mapping[str, dict[str, Any] | None]]
"""By seed and title of a row: what a judgement was made from, None for one that is not there or holds no more."""


def judgements(workspace: Workspace, name: str, category: str, seeds: Sequence[int]) -> HeldBySeed:
    """Those of the table `name` that there are to show."""
    return {seed: {row.title: row.judged(workspace, category, seed).held() for row in TABLES[name].rows} for seed in seeds}


@dataclass(frozen=True)
class CategoryRows:
    """The rows of the table `name` of a category, over the seeds of `held`, measured by `protocol`."""

    workspace: Workspace
    name: str
    category: str
    held: HeldBySeed
    protocol: Protocol

    def all(self) -> list[ScanRow]:
        """All rows of the table, in its order; those that were not run, or are outdated, say so."""
        return [self.row(row) for row in TABLES[self.name].rows]

    def row(self, row: RowOf) -> ScanRow:
        """One of them."""
        judged = {seed: row.judged(self.workspace, self.category, seed) for seed in self.held}
        seeds = tuple(seed for seed, held in self.held.items() if held[row.title] is not None)
        objects = tuple(read_scores([judged[seed].scores(self.protocol) for seed in seeds]))
        is_outdated = any(each.scores(self.protocol).exists() for each in judged.values())
        return ScanRow(
            row.title,
            objects,
            printed_row(self.name, self.category, row.printed),
            seeds,
            OUTDATED if is_outdated else NOT_RUN,
            self._trained_on(row, seeds),
            self._why_not_run([judged[seed] for seed in self.held if seed not in seeds]),
        )

    def alike(self, titles: Sequence[str]) -> list[ScanRow]:
        """The rows of some titles, in their order, over the seeds that all were run for; none if there is no such seed."""
        rows = {row.title: row for row in TABLES[self.name].rows}
        whole = {seed: held for seed, held in self.held.items() if all(held.get(title) for title in titles)}
        return [replace(self, held=whole).row(rows[title]) for title in titles] if whole else []

    def of_each_seed(self) -> list[CategoryRows]:
        """The same, one seed at a time."""
        return [replace(self, held={seed: held}) for seed, held in self.held.items()]

    def _why_not_run(self, missing: Sequence[JudgedScans]) -> str | None:
        """Why there are no judgements, as far as that was told, of those that are `missing` and not outdated."""
        seeds: dict[str, list[str]] = {}
        for each in missing:
            if not each.scores(self.protocol).exists() and (reason := each.reason()):
                seeds.setdefault(reason, []).append(str(each.cell.seed))
        told = (reason if len(own) == len(self.held) else f"seeds {', '.join(own)}: {reason}" for reason, own in seeds.items())
        return "; ".join(told) or None

    def _trained_on(self, row: RowOf, seeds: Sequence[int]) -> str | None:
        """How many labelled objects networks were trained on, and how many that a setting has beside them; where these are
        others from seed to seed, all that there are.
        """
        place = row.workspace(self.workspace)
        pairs = (row.cell(self.category, seed).weights(place) for seed in seeds)
        counts = dict.fromkeys(trained_on(weights[0]) for weights in pairs if weights)
        return " or ".join(f"{labelled} + {others}" if others else str(labelled) for labelled, others in counts) or None
