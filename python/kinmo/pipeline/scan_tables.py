"""Making Tables 2, 3 and 4 of the paper, cell by cell."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product

from kinmo.categories import same_category
from kinmo.config import load_config
from kinmo.errors import InputError, did_you_mean
from kinmo.pipeline.ancsh_files import Cell, Protocol, trained_cells
from kinmo.pipeline.dataset import open_dataset
from kinmo.pipeline.evaluate_scans import EvaluateScans
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.render import Render
from kinmo.pipeline.scan_table_rows import TABLES, RowOf, has_figures
from kinmo.pipeline.stage import Observer, Outcome, Plan, Stage
from kinmo.pipeline.train import Train
from kinmo.pipeline.train_ancsh import TrainAncsh, training_seconds
from kinmo.pipeline.written_scan_tables import WrittenTables
from kinmo.workspace import Workspace

MANY_SEEDS = ("Refrigerator", "Scissors")
"""Categories whose cells have three seeds by default."""
SHARED_SEED = 0
"""Of what all seeds of the networks for scans share."""


@dataclass(frozen=True)
class MakeTable:
    """Do what is missing of a table, a category and a cell at a time, and write it.

    With `hours`, no cell is begun that would not be done by then, as far as that can be told beforehand; cells that are not
    run, and those that cannot be, are shown as such. Without a category it is of those of the paper's that there are labelled
    shapes of. Motion networks go on from those of `start`, if that is given. `seeds` None means three for `MANY_SEEDS`, else
    one; `seed` is the first of them. Scans, motion networks and pseudo labels are the same for all seeds.
    """

    name: str
    workspace: Workspace
    config: str
    method: str
    category: str | None = None
    seeds: int | None = None
    hours: float | None = None
    protocol: Protocol = "kinmo"
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None

    def plan(self) -> Plan:
        steps, seconds = [], 0.0
        for category in self._categories():
            for row, cell in self._cells(category):
                pending = self._pending(row, cell)
                if pending is not None:
                    steps.append(f"{_name(row, cell)}: render, train, judge")
                    seconds += pending
        return Plan(tuple(steps), seconds)

    def run(self, observer: Observer) -> Outcome:
        limit = float("inf") if self.hours is None else time.monotonic() + 3600.0 * self.hours
        failed = 0
        for category in self._categories():
            for row, cell in self._cells(category):
                pending = self._pending(row, cell)
                if pending is None:
                    continue
                if time.monotonic() + pending > limit:
                    observer.note(f"not run: {_name(row, cell)}: it would take longer than --hours")
                    continue
                observer.note(_name(row, cell))
                try:
                    for stage in self._stages(row, cell):
                        stage.run(observer)
                except InputError as error:
                    observer.note(f"not run: {_name(row, cell)}: {error}")
                    failed += 1
        seeds = {category: self._seeds_of(category) for category in self._categories()}
        return replace(WrittenTables(self.workspace, self.name).write(seeds, self.protocol), failed=failed)

    def _pending(self, row: RowOf, cell: Cell) -> float | None:
        """About how many seconds a cell still takes; None if it is done."""
        seconds, steps = 0.0, 0
        for stage in self._stages(row, cell):
            try:
                plan = stage.plan()
            except InputError:  # what it needs is not there yet
                guess = training_seconds(load_config(self.config).ancsh, self.workers) if isinstance(stage, TrainAncsh) else 0.0
                plan = Plan((_name(row, cell),), guess)
            seconds += plan.seconds
            steps += len(plan.steps)
        return seconds if steps else None

    def _categories(self) -> tuple[str, ...]:
        table, dataset = TABLES[self.name], open_dataset(self.workspace)
        known = dataset.categories()
        wanted = table.categories if self.category is None else (self.category,)
        found = tuple(name for want in wanted for name in known if same_category(name, want))
        if not found:
            near = did_you_mean(self.category or "", known)
            problem = f"no labelled shapes of {' or '.join(wanted)}{near}; there are {', '.join(known)}"
            raise InputError(self.workspace.prepared, problem)
        return found

    def _seeds_of(self, category: str) -> tuple[int, ...]:
        count = self.seeds or (3 if any(same_category(category, name) for name in MANY_SEEDS) else 1)
        return tuple(range(self.seed, self.seed + count))

    def _cells(self, category: str) -> Iterator[tuple[RowOf, Cell]]:
        """The rows of the first seed, then those of the next: what is cut off leaves whole comparisons."""
        for seed in self._seeds_of(category):
            for row in TABLES[self.name].rows:
                yield row, row.cell(category, seed)

    def _stages(self, row: RowOf, cell: Cell) -> Iterator[Stage]:
        place = row.workspace(self.workspace)
        if row.setting in ("semi-weakly", "dsg-net"):
            yield Train(self.method, place, self.config, None, SHARED_SEED, self.device, self.workers, self.start)
            yield PseudoLabel(place, self.method, cell.category, None, self.device, self.workers)
        yield Render(place, self.config, cell.category, SHARED_SEED, self.workers, unlabelled=row.setting == "semi")
        tested = Workspace(self.workspace.root, is_rough=row.on_rough)
        if row.on_rough != row.of_rough:
            yield Render(tested, self.config, cell.category, SHARED_SEED, self.workers)
        yield TrainAncsh(place, self.config, cell.category, cell.setting, cell.seed, self.device, self.workers)
        yield EvaluateScans(place, cell, self.device, row.on_rough)


@dataclass(frozen=True)
class JudgeTrained:
    """Judge whatever networks are trained for scans, and write the tables that they have a cell in.

    Without a category those of all categories.
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
        for stage in self._stages():
            try:
                stage.run(observer)
            except InputError as error:
                observer.note(f"not judged: {stage.cell}: {error}")
        texts, data = [], {}
        for name, seeds in self._tables().items():
            outcome = WrittenTables(self.workspace, name).write(seeds, self.protocol)
            texts.append(outcome.text)
            data[f"table-{name}"] = outcome.data
        return Outcome(self.workspace.evaluation, data, "\n".join(texts))

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
        """The tables that have a row with trained networks, and of each the categories and their seeds.

        A category that the paper has no figures of is in the first table alone.
        """
        found: dict[str, dict[str, list[int]]] = {}
        for name, table in TABLES.items():
            seeds: dict[str, set[int]] = {}
            for row in table.rows:
                for cell in trained_cells(row.workspace(self.workspace)):
                    is_wanted = self.category is None or same_category(cell.category, self.category)
                    if is_wanted and cell.setting == row.setting and self._can_be_judged(row, cell, name):
                        seeds.setdefault(cell.category, set()).add(cell.seed)
            if seeds:
                found[name] = {category: sorted(seeds[category]) for category in sorted(seeds)}
        return found

    def _can_be_judged(self, row: RowOf, cell: Cell, table: str) -> bool:
        is_there = table == next(iter(TABLES)) or has_figures(table, cell.category)
        scanned = Workspace(self.workspace.root, is_rough=row.on_rough).scans / cell.category
        return is_there and scanned.is_dir()


def _name(row: RowOf, cell: Cell) -> str:
    return f"{cell}, {row.labels:.0%} of the labels"
