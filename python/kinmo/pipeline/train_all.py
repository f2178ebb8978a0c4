"""The whole way: motion networks, pseudo labels, scans, and the networks that see scans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

from kinmo.config import load_config
from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.wording import duration
from kinmo.dataset.shape_dataset import Dataset, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import ModelFolder
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.scans.render_scans import Render
from kinmo.pipeline.scans.scan_dataset import PAPER_CATEGORIES, open_scan_dataset
from kinmo.pipeline.scans.train_scans import TrainAncsh
from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED, Setting
from kinmo.pipeline.train_motion import Train

NO_CATEGORY = f"no labelled shapes of {', '.join(PAPER_CATEGORIES)}: networks for scans are trained for --category NAME"

NO_LABELS = "no scan is by a pseudo label with the joints that most labelled objects have: networks are trained on these alone"


@dataclass(frozen=True)
class TrainAll:
    """Train the motion networks on all categories; then for one, label what has no joints and do all that scans need.

    Without a category all shapes are labelled, and scans are for those of the paper's five that there are labelled shapes of.
    Networks for scans learn from pseudo labels, of the workspace's method, where there are any, of shapes of other layouts
    before those of DSG-Net's, else from the labelled shapes alone.
    """

    workspace: Workspace
    config: str
    category: str | None = None
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None

    def plan(self) -> Plan:
        """What is still to do; of a stage whose input is not made yet, or will change, a guess."""
        plans = [self._motion.plan()]
        retold = load_config(self.config).refinement != ModelFolder(self.workspace.motion.models).config().refinement
        labels_change = is_changed = retold or plans[0].seconds > 0.0
        for stage in self._later(open_dataset(self.workspace)):
            try:
                is_guess = labels_change if isinstance(stage, Render) else is_changed
                plans.append(stage.guess() if is_guess else stage.plan())
            except InputError:
                plans.append(stage.guess())
            is_changed |= plans[-1].seconds > 0.0
            labels_change |= isinstance(stage, PseudoLabel) and is_changed
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        plan = self.plan()
        for step in plan.steps:
            observer.note(f"to do: {step}")
        if plan.steps:
            observer.note(f"about {duration(plan.seconds)} in all")
        texts: list[str] = []
        results: dict[str, Any] = {}
        sees_scans, failed = False, 0
        for stage in chain([self._motion], self._later(open_dataset(self.workspace))):
            if isinstance(stage, TrainAncsh) and stage.setting == "supervised":
                self._tell_of_missing_labels(stage.category, observer)
            outcome = stage.run(observer)
            texts.append(outcome.text)
            failed += outcome.failed
            sees_scans |= isinstance(stage, TrainAncsh)
            if isinstance(stage, (Train, TrainAncsh)):
                results |= outcome.data
        if not sees_scans:
            observer.note(NO_CATEGORY)
        return Outcome(self.workspace.models, results, "\n".join(filter(None, texts)), failed)

    def _tell_of_missing_labels(self, category: str | None, observer: Observer) -> None:
        if open_dataset(self.workspace, category).unlabelled:
            observer.note(f"{category}: {NO_LABELS}")

    @property
    def _motion(self) -> Train:
        how = (self.seed, self.device, self.workers)
        return Train("motion", self.workspace.motion, self.config, None, *how, self.start)

    def _later(self, dataset: Dataset) -> Iterator[LaterStage]:
        """What follows the motion networks; which stages come next may depend on what was done before."""
        if any(self.category is None or same_category(entry.category, self.category) for entry in dataset.unlabelled):
            yield PseudoLabel(self.workspace, self.category, None, self.device, self.workers)
        for category in self._categories(dataset):
            yield Render(self.workspace, self.config, category, self.seed, self.workers)
        for category in self._categories(dataset):
            setting = self._setting(category)
            place = self.workspace if setting in PSEUDO_LABELLED else self.workspace.without_pseudo_labels
            yield TrainAncsh(place, self.config, category, setting, self.seed, self.device, self.workers)

    def _setting(self, category: str) -> Setting:
        """By pseudo labels of shapes of other layouts, else of DSG-Net's, unless it is clear by now that there are none."""
        try:
            dataset = open_scan_dataset(self.workspace, category)
        except InputError:
            return "semi-weakly"
        return next((setting for setting in PSEUDO_LABELLED if dataset.beside(setting)), "supervised")

    def _categories(self, dataset: Dataset) -> list[str]:
        known = sorted({entry.category for entry in dataset.labelled[Split.TRAIN]})
        wanted = PAPER_CATEGORIES if self.category is None else (self.category,)
        found = [name for want in wanted for name in known if same_category(name, want)]
        if self.category is not None and not found:
            near = did_you_mean(self.category, known)
            there = f"; there are {', '.join(known)}" if known else ""
            problem = f"expected a labelled shape of {self.category} to train on{near}{there}"
            raise InputError(self.workspace.prepared, problem)
        return found
