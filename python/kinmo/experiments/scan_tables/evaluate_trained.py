"""Judging whatever networks are trained for scans, for the tables that they are in."""

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
from kinmo.experiments.scan_tables.table_rows import TABLES, RowOf, has_figures, is_printed
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.scan_dataset import scanned_categories
from kinmo.pipeline.scans.scan_networks import Cell, Protocol, trained_cells
from kinmo.pipeline.scans.scored_scans import NothingToJudgeBy


@dataclass(frozen=True)
class JudgeTrained:
    """Judge whatever networks are trained for scans, and write the tables that they have a cell in.

    Without a category those of all categories; with one, also the paper's tables of it that nothing was trained for yet.
    """

    workspace: Workspace
    category: str | None = None
    protocol: Protocol = "kinmo"
    device: str = "auto"

    def plan(self) -> Plan:
        plans = []
        for stage in self._stages():
            with suppress(InputError):  # told when it is run
                plans.append(stage.plan())
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        failed = 0
        for stage in self._stages():
            try:
                stage.run(observer)
            except InputError as error:
                failed += not isinstance(error, NothingToJudgeBy)  # of few shapes none may be left to test
                observer.problem(f"not judged: {stage.cell.title(stage.workspace)}: {error}")
        texts, data = [], {}
        for name, seeds in self._tables().items():
            outcome = WrittenTables(self.workspace, name).write(seeds, self.protocol)
            texts.append(outcome.text)
            data[f"table-{name}"] = outcome.data
        return Outcome(self.workspace.evaluation, data, "\n".join(texts), failed)

    def _stages(self) -> Iterator[EvaluateScans]:
        done = set()
        for name, seeds in self._tables().items():
            for row, category in product(TABLES[name].rows, seeds):
                for seed in seeds[category]:
                    place, cell = row.workspace(self.workspace), row.cell(category, seed)
                    is_new = (place.path, cell, row.on_rough) not in done
                    if is_new and cell.weights(place) and self._can_be_judged(row, cell, name):
                        done.add((place.path, cell, row.on_rough))
                        yield EvaluateScans(place, cell, self.device, row.on_rough)

    def _tables(self) -> dict[str, dict[str, list[int]]]:
        """The tables to write, and of each the categories and their seeds.

        Of the paper's tables a category that it has no figures of is in the first alone.
        """
        found: dict[str, dict[str, list[int]]] = {}
        for name, table in TABLES.items():
            seeds: dict[str, set[int]] = {}
            for row in table.rows:
                for cell in trained_cells(row.workspace(self.workspace)):
                    is_wanted = self.category is None or same_category(cell.category, self.category)
                    if is_wanted and cell.setting == row.setting and self._can_be_judged(row, cell, name):
                        seeds.setdefault(cell.category, set()).add(cell.seed)
            if self.category is not None and not seeds and is_printed(name, self.category):
                seeds = {category: {0} for category in self._spelled(self.category)}
            if seeds:
                found[name] = {category: sorted(seeds[category]) for category in sorted(seeds)}
        return found

    def _spelled(self, category: str) -> tuple[str, ...]:
        """A category as the prepared shapes spell it; nothing if there are none of it."""
        with suppress(InputError):
            return open_dataset(self.workspace, category).categories()
        return ()

    def _can_be_judged(self, row: RowOf, cell: Cell, table: str) -> bool:
        return self._is_of(table, cell.category) and self._is_scanned(cell.category, by_rough=row.on_rough)

    def _is_of(self, table: str, category: str) -> bool:
        """Whether a table is of a category; that of sensors is once both have seen it."""
        if any(row.on_rough for row in TABLES[table].rows):
            return self._is_scanned(category, by_rough=True)
        return table == next(iter(TABLES)) or has_figures(table, category)

    def _is_scanned(self, category: str, by_rough: bool) -> bool:
        return category in scanned_categories(Workspace(self.workspace.root, is_rough=by_rough))
