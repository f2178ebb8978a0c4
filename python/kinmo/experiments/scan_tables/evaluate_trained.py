"""The stage that evaluates all trained networks for scans, and writes their tables."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import product

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.table_rows import TABLES, TableRow, is_about, is_printed
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.experiments.variant_workspaces import Variant
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.scan_dataset import scanned_categories
from kinmo.pipeline.scans.scan_networks import trained_runs
from kinmo.pipeline.scans.scan_scores import NoTestScans, Protocol, ScanScores


@dataclass(frozen=True)
class EvaluateTrained:
    """Evaluate every trained network for scans, and write the tables that have a row for it.

    A `category` alone comes with all of the paper's tables that print figures for it. With `details`, the figures of every part
    are printed, as the `protocol` defines them.
    """

    workspace: Workspace
    category: str | None = None
    protocol: Protocol = "kinmo"
    device: str = "auto"
    details: bool = False

    def plan(self) -> Plan:
        """List the networks whose scores are not up to date."""
        plans = []
        for stage in self._stages():
            with suppress(InputError):  # reported by run
                plans.append(stage.plan())
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        """Score the networks, and write the tables."""
        failed = 0
        for stage in self._stages():
            try:
                stage.run(observer)
            except InputError as error:
                failed += not isinstance(error, NoTestScans)  # of few shapes none may be in the test split
                observer.problem(f"not evaluated: {stage.scores.run}: {error}")
        texts, data = [], {}
        for name, seeds in self._tables().items():
            outcome = WrittenTables(self.workspace, name, self.details).write(seeds, self.protocol)
            texts.append(outcome.text)
            data[f"table-{name}"] = outcome.data
        return Outcome(self.workspace.evaluation, data, "\n".join(texts), failed)

    def _stages(self) -> Iterator[EvaluateScans]:
        done: set[ScanScores] = set()
        for name, seeds in self._tables().items():
            for row, category in product(TABLES[name].rows, seeds):
                for seed in seeds[category]:
                    scores = row.scores(self.workspace, category, seed)
                    is_trained = scores.run.weights(scores.workspace) is not None
                    if scores not in done and is_trained and self._is_possible(row, category, name):
                        done.add(scores)
                        yield EvaluateScans(scores, self.device)

    def _tables(self) -> dict[str, dict[str, list[int]]]:
        """Tables to write, and the seeds of each of their categories.

        A category without printed figures appears in the first of the paper's tables alone.
        """
        found: dict[str, dict[str, list[int]]] = {}
        for name, table in TABLES.items():
            seeds: dict[str, set[int]] = {}
            for row in table.rows:
                for run in trained_runs(row.variant.workspace(self.workspace)):
                    is_wanted = self.category is None or same_category(run.category, self.category)
                    if is_wanted and run.setting == row.setting and self._is_possible(row, run.category, name):
                        seeds.setdefault(run.category, set()).add(run.seed)
            if self.category is not None and not seeds and is_printed(name, self.category):
                with suppress(InputError):  # there are no such shapes
                    seeds = {spelled: {0} for spelled in open_dataset(self.workspace, self.category).categories()}
            if seeds:
                found[name] = {category: sorted(seeds[category]) for category in sorted(seeds)}
        return found

    def _is_possible(self, row: TableRow, category: str, table: str) -> bool:
        """True if a table is about a category, and the scans that a row is tested on are there."""
        needed = {row.tested_variant}
        if any(other.tested_on == "noisy" for other in TABLES[table].rows):
            needed.add(Variant(is_noisy=True))
        elif table != next(iter(TABLES)) and not is_about(table, category):
            return False
        return all(category in scanned_categories(variant.workspace(self.workspace)) for variant in needed)
