"""The stage `table`: it trains and evaluates all networks of a table of scans."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from kinmo.config import load_config
from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan, Stage
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.table_rows import TABLES, TableRow
from kinmo.experiments.scan_tables.written_tables import WrittenTables
from kinmo.experiments.self_training.self_label_scans import SelfLabelScans
from kinmo.experiments.variant_workspaces import Variant
from kinmo.learning.weights import pick_device
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.motion_models import CONTINUED, TRAINERS
from kinmo.pipeline.pseudo_label_shapes import PseudoLabel
from kinmo.pipeline.scans.evaluate_scans import EvaluateScans
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.scan_networks import trained_runs
from kinmo.pipeline.scans.scan_scores import Protocol
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.scans.training_settings import EXTRA_LABELS
from kinmo.pipeline.train_motion import TrainMotion, weights_to_start_from
from kinmo.scans.files.scan_file import Role

WORDS: Mapping[type, str] = {
    TrainMotion: "train motion networks",
    PseudoLabel: "label",
    RenderScans: "render",
    TrainScans: "train",
    SelfLabelScans: "self-label",
    EvaluateScans: "evaluate",
}
"""Short names of the stages, for plans."""
CATEGORIES_WITH_SEEDS = ("Refrigerator", "Scissors")  # categories that are trained with three seeds by default
TOO_LONG = "it would have taken longer than --hours"
SHARED_SEED = 0  # seed of the stages that all seeds of the networks for scans share


class CannotBeRun(InputError):
    """A row lacks labels to learn from, or scans to test on, after everything possible was done."""


@dataclass(frozen=True)
class MakeTable:
    """Do what is missing for a table, one category and row after the other, and write it."""

    name: str  # a key of `TABLES`
    workspace: Workspace
    config: str  # name or path of the configuration
    methods: tuple[str, ...]  # methods whose pseudo labels are used
    category: str | None = None  # None for the table's own categories
    seeds: int | None = None  # number of seeds; None for three or one, depending on the category
    hours: float | None = None  # begin nothing that would end later
    protocol: Protocol = "kinmo"  # definition of errors in the printed table
    seed: int = 0  # the first one
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None  # continue the motion networks from those of this workspace
    details: bool = False  # print all figures

    def plan(self) -> Plan:
        """List the rows that are not done, with their stages."""
        self._check_options()
        steps, impossible, seconds, failed = [], [], 0.0, 0
        known: dict[Stage, Plan] = {}
        for row, category, seed in self._rows():
            name = f"{category}, {row.title}, seed {seed}"
            try:
                plan = self._pending(row, category, seed, known)
                if plan.steps:
                    steps.append(f"{name}: {', '.join(plan.steps)}")
                    seconds += plan.seconds
            except InputError as error:
                impossible.append(f"{name}: cannot be run: {error}")
                failed += self._is_failure(row, category, seed)
        return Plan(tuple(steps), seconds, tuple(impossible), failed)

    def run(self, observer: Observer) -> Outcome:
        """Do what is missing, and write the table."""
        self._check_options()
        limit = float("inf") if self.hours is None else time.monotonic() + 3600.0 * self.hours
        failed = 0
        for row, category, seed in self._rows():
            name = f"{category}, {row.title}, seed {seed}"
            scores = row.scores(self.workspace, category, seed)
            try:
                plan = self._pending(row, category, seed, {})
                if not plan.steps:
                    continue
                if time.monotonic() + plan.seconds > limit:
                    observer.problem(f"not run: {name}: {TOO_LONG}")
                    scores.record_reason(TOO_LONG)
                    continue
                observer.note(name)
                for stage in self._stages(row, category, seed):
                    failed += stage.run(observer).failed
            except (InputError, ChildProcessError) as error:
                observer.problem(f"not run: {name}: {error}")
                scores.record_reason(getattr(error, "problem", str(error)))
                failed += self._is_failure(row, category, seed)
        seeds = {category: self._shown_seeds(category) for category in self._categories()}
        written = WrittenTables(self.workspace, self.name, self.details).write(seeds, self.protocol)
        return replace(written, failed=failed)

    def _is_failure(self, row: TableRow, category: str, seed: int) -> bool:
        """True if a row with an error counts as failed. Few workspaces have oracle labels."""
        return not (row.setting == "oracle" and self._cannot_be_run(row, category, seed))

    def _check_options(self) -> None:
        """Raise InputError for options with which no row could be run."""
        config = load_config(self.config)
        pick_device(self.device)
        if self.start is not None:
            for model in CONTINUED:
                weights_to_start_from(self.start, self.workspace, model, getattr(config, TRAINERS[model][0]))

    def _pending(self, row: TableRow, category: str, seed: int, known: dict[Stage, Plan]) -> Plan:
        """Short names of the stages that a row still needs, and their duration.

        Stages in `known` were counted for an earlier row; the others are added to it. Raises CannotBeRun, or InputError if an
        earlier stage has a problem.
        """
        self._check(row, category)
        words: list[str] = []
        seconds = 0.0
        is_changed = False  # inputs of a stage, by those before it
        for stage in self._stages(row, category, seed):
            if stage not in known:
                try:
                    known[stage] = stage.guess() if is_changed and not isinstance(stage, TrainMotion) else stage.plan()
                except InputError as error:
                    if not words and isinstance(stage, TrainScans | EvaluateScans):
                        raise CannotBeRun(error.where, error.problem, error.field) from None
                    if not words:
                        raise
                    known[stage] = Plan((WORDS[type(stage)],), 0.0)
                seconds += known[stage].seconds
            is_changed |= known[stage].seconds > 0.0
            if known[stage].steps and WORDS[type(stage)] not in words:
                words.append(WORDS[type(stage)])
        return Plan(tuple(words), seconds)

    def _check(self, row: TableRow, category: str) -> None:
        """Raise CannotBeRun if there are no shapes for the labels that a row needs."""
        needed = EXTRA_LABELS.get(row.setting)
        if needed is not None and not needed.count(open_dataset(row.variant.workspace(self.workspace), category)):
            layout = " in DSG-Net's layout" if row.variant.generated else ""
            raise CannotBeRun(self.workspace.prepared, f"no shapes of {category}{layout} {needed.shapes}")

    def _cannot_be_run(self, row: TableRow, category: str, seed: int) -> bool:
        """True if a row lacks labels to learn from, after everything possible was done."""
        try:
            self._pending(row, category, seed, {})
        except InputError as error:
            return isinstance(error, CannotBeRun)
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
        count = self.seeds or (3 if any(same_category(category, name) for name in CATEGORIES_WITH_SEEDS) else 1)
        return tuple(range(self.seed, self.seed + count))

    def _shown_seeds(self, category: str) -> list[int]:
        """The seeds that are asked for, and those of trained networks: asking for fewer removes nothing from a table."""
        rows = TABLES[self.name].rows
        runs = (run for row in rows for run in trained_runs(row.variant.workspace(self.workspace)))
        settings = {row.setting for row in rows}
        trained = {run.seed for run in runs if run.category == category and run.setting in settings}
        return sorted(trained.union(self._seeds_of(category)))

    def _rows(self) -> Iterator[tuple[TableRow, str, int]]:
        """Rows of each category: all of the first seed, then those of the next, so that whole comparisons are done first."""
        rows = [row for row in TABLES[self.name].rows if row.setting != "semi-weakly" or row.method in self.methods]
        return ((row, category, seed) for category in self._categories() for seed in self._seeds_of(category) for row in rows)

    def _stages(self, row: TableRow, category: str, seed: int) -> Iterator[TrainMotion | LaterStage]:
        root, how = self.workspace, (self.device, self.workers)
        place = row.variant.workspace(root)
        if row.setting == "semi-weakly":
            labelling = row.variant.labelling(root)
            yield TrainMotion(row.method, labelling, self.config, None, SHARED_SEED, *how, self.start)
            yield PseudoLabel(labelling, category, row.method, None, *how)
        needed = EXTRA_LABELS.get(row.setting)
        yield self._render(row.variant, category, needed.roles if needed else (), row.method)
        if row.tested_variant != row.variant:
            yield self._render(row.tested_variant, category)
        if row.setting == "self-training":
            yield TrainScans(place, self.config, category, "supervised", row.method, seed, *how)
            yield SelfLabelScans(place, category, load_config(self.config).ancsh.confidence, seed, *how)
        yield TrainScans(place, self.config, category, row.setting, row.method, seed, *how)
        yield EvaluateScans(row.scores(root, category, seed), self.device)

    def _render(
        self, variant: Variant, category: str, roles: tuple[Role, ...] = (), method: str = DEFAULT_METHOD
    ) -> RenderScans:
        sensor = load_config(self.config).scans.noisy_sensor if variant.is_noisy else None
        place = variant.workspace(self.workspace)
        return RenderScans(place, self.config, category, SHARED_SEED, self.workers, roles, method, sensor)
