"""Making Tables 2, 3 and 4 of the paper, cell by cell."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan, Stage
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.table_rows import TABLES, RowOf
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.learning.weights import pick_device
from kinmo.pipeline.motion_models import CONTINUED, TRAINERS
from kinmo.pipeline.network_training import config_to_train_by
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_networks import Protocol, trained_cells
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED, SUPPLEMENTS
from kinmo.pipeline.train_motion import SECTIONS, Train, weights_to_start_from

WORDS: Mapping[type, str] = {
    Train: "train motion networks",
    PseudoLabel: "label",
    Render: "render",
    TrainAncsh: "train",
    EvaluateScans: "judge",
}
"""What the stages of a cell are called in a plan."""
MANY_SEEDS = ("Refrigerator", "Scissors")
"""Categories whose cells have three seeds by default."""
TOO_LONG = "it would have taken longer than --hours"
SHARED_SEED = 0
"""Of what all seeds of the networks for scans share."""


class CannotBeRun(InputError):
    """A cell lacks what its networks are to learn from or to be judged on, with all done that could give it that."""


@dataclass(frozen=True)
class MakeTable:
    """Do what is missing of a table, a category and a cell at a time, and write it.

    With `hours`, no cell is begun that would not be done by then, as far as that can be told beforehand; cells that are not
    run, and those that cannot be, are shown as such. Without a category it is of those of the paper's that there are labelled
    shapes of. Motion networks go on from those of `start`, if that is given. `seeds` None means three for `MANY_SEEDS`, else
    one; `seed` is the first of them. Of rows that learn from pseudo labels those of `methods` are made. Scans, motion networks
    and pseudo labels are the same for all seeds.
    """

    name: str
    workspace: Workspace
    config: str
    methods: tuple[str, ...]
    category: str | None = None
    seeds: int | None = None
    hours: float | None = None
    protocol: Protocol = "kinmo"
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None

    def plan(self) -> Plan:
        self._check_options()
        steps, impossible, seconds = [], [], 0.0
        known: dict[Stage, Plan] = {}
        for category in self._categories():
            for row, seed in self._cells(category):
                name = _name(row, category, seed)
                try:
                    plan = self._pending(row, category, seed, known)
                    if plan.steps:
                        steps.append(f"{name}: {', '.join(plan.steps)}")
                        seconds += plan.seconds
                except InputError as error:
                    impossible.append(f"{name}: cannot be run: {error}")
        return Plan(tuple(steps), seconds, tuple(impossible))

    def run(self, observer: Observer) -> Outcome:
        self._check_options()
        limit = float("inf") if self.hours is None else time.monotonic() + 3600.0 * self.hours
        failed = 0
        for category in self._categories():
            for row, seed in self._cells(category):
                name = _name(row, category, seed)
                try:
                    plan = self._pending(row, category, seed, {})
                    if not plan.steps:
                        continue
                    if time.monotonic() + plan.seconds > limit:
                        observer.problem(f"not run: {name}: {TOO_LONG}")
                        row.judged(self.workspace, category, seed).leave_out(TOO_LONG)
                        continue
                    observer.note(name)
                    for stage in self._stages(row, category, seed):
                        failed += stage.run(observer).failed
                except (InputError, ChildProcessError) as error:
                    observer.problem(f"not run: {name}: {error}")
                    row.judged(self.workspace, category, seed).leave_out(getattr(error, "problem", str(error)))
                    # few workspaces have labels that are held back
                    failed += not (row.setting == "ceiling" and self._cannot_be_run(row, category, seed))
        seeds = {category: self._shown_seeds(category) for category in self._categories()}
        written = WrittenTables(self.workspace, self.name).write(seeds, self.protocol)
        return replace(written, failed=failed)

    def _check_options(self) -> None:
        """Raises InputError for what no cell could be run with."""
        config = config_to_train_by(self.config, (*SECTIONS, "ancsh"))
        pick_device(self.device)
        if self.start is not None:
            for model in CONTINUED:
                weights_to_start_from(self.start, self.workspace, model, getattr(config, TRAINERS[model][0]))

    def _pending(self, row: RowOf, category: str, seed: int, known: dict[Stage, Plan]) -> Plan:
        """What a cell still takes, in words, and about how many seconds but for stages in `known`, to which its own are added.

        Raises CannotBeRun, or InputError if a stage that comes before has a problem.
        """
        self._check(row, category)
        words: list[str] = []
        seconds = 0.0
        is_changed = False  # what a stage works on, by those before it
        for stage in self._stages(row, category, seed):
            if stage not in known:
                try:
                    known[stage] = stage.guess() if is_changed and not isinstance(stage, Train) else stage.plan()
                except InputError as error:
                    if not words and isinstance(stage, TrainAncsh | EvaluateScans):
                        raise CannotBeRun(error.where, error.problem, error.field) from None
                    if not words:
                        raise
                    known[stage] = Plan((WORDS[type(stage)],), 0.0)
                seconds += known[stage].seconds
            is_changed |= known[stage].seconds > 0.0
            if known[stage].steps and WORDS[type(stage)] not in words:
                words.append(WORDS[type(stage)])
        return Plan(tuple(words), seconds)

    def _check(self, row: RowOf, category: str) -> None:
        """Raises CannotBeRun if there are no shapes of the kind that networks are to learn from beside the labelled ones."""
        needed = SUPPLEMENTS.get(row.setting)
        if needed is not None and not needed.count(open_dataset(row.workspace(self.workspace), category)):
            raise CannotBeRun(self.workspace.prepared, f"no shapes of {category} {needed.shapes}")

    def _cannot_be_run(self, row: RowOf, category: str, seed: int) -> bool:
        """Whether a cell lacks what it learns from, with all done that could be."""
        try:
            self._pending(row, category, seed, {})
        except CannotBeRun:
            return True
        except InputError:
            pass
        return False

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

    def _shown_seeds(self, category: str) -> list[int]:
        """Those that are asked for, and those that there are networks of: fewer seeds take nothing out of a table."""
        cells = (cell for row in TABLES[self.name].rows for cell in trained_cells(row.workspace(self.workspace)))
        settings = {row.setting for row in TABLES[self.name].rows}
        trained = {cell.seed for cell in cells if cell.category == category and cell.setting in settings}
        return sorted(trained.union(self._seeds_of(category)))

    def _cells(self, category: str) -> Iterator[tuple[RowOf, int]]:
        """The rows of the first seed, then those of the next: what is cut off leaves whole comparisons."""
        rows = [row for row in TABLES[self.name].rows if row.setting not in PSEUDO_LABELLED or row.method in self.methods]
        return ((row, seed) for seed in self._seeds_of(category) for row in rows)

    def _stages(self, row: RowOf, category: str, seed: int) -> Iterator[Train | LaterStage]:
        place, cell = row.workspace(self.workspace), row.cell(category, seed)
        if row.setting in PSEUDO_LABELLED:
            yield Train(row.method, place.motion, self.config, None, SHARED_SEED, self.device, self.workers, self.start)
            yield PseudoLabel(place.labelling, category, None, self.device, self.workers)
        needed = SUPPLEMENTS.get(row.setting)
        yield Render(place, self.config, category, SHARED_SEED, self.workers, needed.scanned if needed else ())
        tested = Workspace(self.workspace.root, is_rough=row.on_rough)
        if row.on_rough != row.of_rough:
            yield Render(tested, self.config, category, SHARED_SEED, self.workers, beside=())
        yield TrainAncsh(place, self.config, category, row.setting, seed, self.device, self.workers)
        yield EvaluateScans(place, cell, self.device, row.on_rough)


def _name(row: RowOf, category: str, seed: int) -> str:
    return f"{category}, {row.title}, seed {seed}"
