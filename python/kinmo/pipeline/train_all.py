"""The stage `train all`: motion networks, pseudo labels, scans, and networks for scans."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from typing import Any

from kinmo.config import load_config
from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.wording import duration
from kinmo.dataset.shape_dataset import ShapeDataset, open_dataset
from kinmo.dataset.splits import Split
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.pseudo_label_shapes import PseudoLabel
from kinmo.pipeline.scans.render_scans import RenderScans
from kinmo.pipeline.scans.scan_dataset import PAPER_CATEGORIES, open_scan_dataset
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.pipeline.train_motion import TrainMotion

NO_CATEGORY = f"no labelled shapes of {', '.join(PAPER_CATEGORIES)}: name another category with --category for scan networks"
NO_LABELS = "no pseudo-labelled object has the joints of most labelled ones: networks are trained on labelled objects alone"


@dataclass(frozen=True)
class TrainAll:
    """Train the motion networks on all categories, label unlabelled shapes, scan both, and train networks for the scans.

    Networks for scans learn from pseudo labels where there are any, otherwise from the labelled shapes alone.
    """

    workspace: Workspace
    config: str
    category: str | None = None  # label and scan it alone; None for all, with scans of the paper's five categories
    method: str = DEFAULT_METHOD  # gives the pseudo labels
    seed: int = 0
    device: str = "auto"
    workers: int = 1
    start: Workspace | None = None  # continue the motion networks from its networks

    def plan(self) -> Plan:
        """List what is left to do; estimate stages whose inputs are missing or will change."""
        plans = [self._motion.plan()]
        trained = ModelFolder(self.workspace.models).config()
        labels_change = is_changed = load_config(self.config).refinement != trained.refinement or plans[0].seconds > 0.0
        for stage in self._later(open_dataset(self.workspace)):
            try:
                is_guess = labels_change if isinstance(stage, RenderScans) else is_changed
                plans.append(stage.guess() if is_guess else stage.plan())
            except InputError:
                plans.append(stage.guess())
            is_changed |= plans[-1].seconds > 0.0
            labels_change |= isinstance(stage, PseudoLabel) and is_changed
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        """Run all stages one after the other."""
        plan = self.plan()
        for step in plan.steps:
            observer.note(f"to do: {step}")
        if plan.steps:
            observer.note(f"about {duration(plan.seconds)} in all")
        texts: list[str] = []
        results: dict[str, Any] = {}
        trains_scans, failed = False, 0
        for stage in chain([self._motion], self._later(open_dataset(self.workspace))):
            if isinstance(stage, TrainScans):
                trains_scans = True
                if stage.setting == "supervised" and open_dataset(self.workspace, stage.category).unlabelled:
                    observer.note(f"{stage.category}: {NO_LABELS}")
            try:
                outcome = stage.run(observer)
            except InputError as error:
                if self.category is not None or not isinstance(stage, (RenderScans, TrainScans)):
                    raise
                observer.problem(f"{stage.category}: skipped: {error}")  # the other categories do not depend on it
                failed += 1
                continue
            texts.append(outcome.text)
            failed += outcome.failed
            if isinstance(stage, (TrainMotion, TrainScans)):
                results |= outcome.data
        if not trains_scans:
            observer.note(NO_CATEGORY)
        return Outcome(self.workspace.models, results, "\n".join(filter(None, texts)), failed)

    @property
    def _motion(self) -> TrainMotion:
        return TrainMotion("motion", self.workspace, self.config, None, self.seed, self.device, self.workers, self.start)

    def _later(self, dataset: ShapeDataset) -> Iterator[LaterStage]:
        """Stages after the motion networks; each may depend on the results of those before it."""
        if any(self.category is None or same_category(entry.category, self.category) for entry in dataset.unlabelled):
            yield PseudoLabel(self.workspace, self.category, self.method, device=self.device, workers=self.workers)
        categories = self._categories(dataset)
        for category in categories:
            yield RenderScans(self.workspace, self.config, category, self.seed, self.workers, method=self.method)
        for category in categories:
            setting = self._setting(category)
            yield TrainScans(self.workspace, self.config, category, setting, self.method, self.seed, self.device, self.workers)

    def _setting(self, category: str) -> Setting:
        """Semi-weakly supervised, unless it is clear by now that no pseudo label can be used."""
        try:
            dataset = open_scan_dataset(self.workspace, category, self.method)
        except InputError:
            return "semi-weakly"
        return "semi-weakly" if dataset.extra("semi-weakly") else "supervised"

    def _categories(self, dataset: ShapeDataset) -> list[str]:
        known = sorted({entry.category for entry in dataset.labelled[Split.TRAIN]})
        wanted = PAPER_CATEGORIES if self.category is None else (self.category,)
        found = [name for want in wanted for name in known if same_category(name, want)]
        if self.category is not None and not found:
            near, there = did_you_mean(self.category, known), f"; there are {', '.join(known)}" if known else ""
            raise InputError(self.workspace.prepared, f"expected a labelled shape of {self.category} to train on{near}{there}")
        return found
