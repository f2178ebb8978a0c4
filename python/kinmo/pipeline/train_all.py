"""The whole way: motion networks, pseudo labels, scans, and the networks that see scans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from kinmo.categories import same_category
from kinmo.errors import InputError
from kinmo.pipeline.dataset import Dataset, open_dataset
from kinmo.pipeline.pseudo_label import SECONDS_PER_SHAPE, PseudoLabel
from kinmo.pipeline.scans.dataset import PAPER_CATEGORIES, open_scan_dataset
from kinmo.pipeline.scans.render import Render
from kinmo.pipeline.scans.settings import PSEUDO_LABELLED, Setting
from kinmo.pipeline.scans.train import TrainAncsh
from kinmo.pipeline.stage import Observer, Outcome, Plan, Stage
from kinmo.pipeline.train import Train
from kinmo.splits import Split
from kinmo.wording import counted
from kinmo.workspace import Workspace

NO_CATEGORY = f"no labelled shapes of {', '.join(PAPER_CATEGORIES)}: networks for scans are trained for --category NAME"


@dataclass(frozen=True)
class TrainAll:
    """Train the motion networks on all categories; then for one, label what has no joints and do all that scans need.

    Without a category all shapes are labelled, and scans are for those of the paper's five that there are labelled shapes of.
    Networks for scans learn from pseudo labels, of the workspace's method, where there are any, else from the labelled shapes
    alone.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None

    def plan(self) -> Plan:
        """What is still to do. Of a stage whose input is not made yet this is what it will be at most."""
        steps: list[str] = []
        seconds = 0.0
        for stage, otherwise in self._stages(open_dataset(self.workspace)):
            try:
                plan = stage.plan()
            except InputError:
                plan = otherwise()
            if steps and not plan.steps:
                plan = otherwise()  # it is done for what there is, which the stages before it change
            steps += plan.steps
            seconds += plan.seconds
        return Plan(tuple(steps), seconds)

    def run(self, observer: Observer) -> Outcome:
        plan = self.plan()
        for step in plan.steps:
            observer.note(f"to do: {step}")
        if plan.steps:
            observer.note(f"about {max(round(plan.seconds / 60.0), 1)} minutes in all")
        texts: list[str] = []
        results: dict[str, Any] = {}
        sees_scans, failed = False, 0
        for stage, _ in self._stages(open_dataset(self.workspace)):
            outcome = stage.run(observer)
            texts.append(outcome.text)
            failed += outcome.failed
            sees_scans |= isinstance(stage, TrainAncsh)
            if isinstance(stage, (Train, TrainAncsh)):
                results |= outcome.data
        if not sees_scans:
            observer.note(NO_CATEGORY)
        return Outcome(self.workspace.models, results, "\n".join(filter(None, texts)), failed)

    def _stages(self, dataset: Dataset) -> Iterator[tuple[Stage, Callable[[], Plan]]]:
        """Each with a guess at its plan for when what comes before it is not done; what comes next may depend on what is."""
        nothing = Plan((), 0.0)
        how = (self.seed, self.device, self.workers)
        yield Train("motion", self.workspace.motion, self.config, None, *how, self.start), lambda: nothing
        count = sum(self.category is None or same_category(entry.category, self.category) for entry in dataset.unlabelled)
        if count:
            labelling = Plan(
                (f"label {counted(count, 'shape')} by {self.workspace.method}",), count * SECONDS_PER_SHAPE / self.workers
            )
            yield PseudoLabel(self.workspace, self.category, None, self.device, self.workers), lambda: labelling
        for category in self._categories(dataset):
            yield Render(self.workspace, self.config, category, self.seed, self.workers), lambda: nothing
        for category in self._categories(dataset):
            setting = self._setting(category)
            place = self.workspace if setting in PSEUDO_LABELLED else self.workspace.motion
            stage = TrainAncsh(place, self.config, category, setting, *how)
            training = Plan((f"train ancsh and npcs ({category})",), stage.guessed_seconds())
            yield stage, lambda training=training: training  # type: ignore[misc]

    def _setting(self, category: str) -> Setting:
        """Semi-weakly, unless it is clear by now that there are no pseudo labels of shapes that networks could learn from."""
        try:
            dataset = open_scan_dataset(self.workspace, category)
        except InputError:
            return "semi-weakly"
        return "semi-weakly" if dataset.beside("semi-weakly") else "supervised"

    def _categories(self, dataset: Dataset) -> list[str]:
        known = sorted({entry.category for entry in dataset.labelled[Split.TRAIN]})
        wanted = PAPER_CATEGORIES if self.category is None else (self.category,)
        found = [name for want in wanted for name in known if same_category(name, want)]
        if self.category is not None and not found:
            raise InputError(self.workspace.prepared, f"expected a labelled shape of {self.category} to train on")
        return found
