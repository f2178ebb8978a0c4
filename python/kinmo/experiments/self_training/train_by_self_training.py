"""The stage `train ancsh --setting self-training`: supervised networks, their labels, and networks trained on these."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from kinmo.config import load_config
from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.self_training.self_label_scans import SelfLabelScans
from kinmo.pipeline.scans.scan_dataset import scanned_categories
from kinmo.pipeline.scans.train_scans import TrainScans


@dataclass(frozen=True)
class TrainBySelfTraining:
    """Train supervised networks, label scans of unlabelled objects with them, and train networks on both.

    Attributes:
        workspace: folder of the workspace.
        config: name or path of the configuration.
        category: the category; None for all scanned ones.
        seed: seed of everything random.
        device: where networks are trained and run.
        workers: number of processes.
    """

    workspace: Path
    config: str
    category: str | None = None
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """List what is left to do; estimate stages whose inputs will change."""
        plans: list[Plan] = []
        for stage in self._stages():
            is_changed = any(plan.seconds > 0.0 for plan in plans)
            plans.append(stage.guess() if is_changed else stage.plan())
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        """Run all stages. A missing scan to label is reported before anything is trained."""
        outcome = Outcome(self.workspace)
        stages = list(self._stages())
        for stage in stages:
            if isinstance(stage, SelfLabelScans):
                stage.guess()
        for stage in stages:
            outcome = stage.run(observer)
        return outcome

    def _stages(self) -> Iterator[LaterStage]:
        place, how = Workspace(self.workspace), (self.device, self.workers)
        known = scanned_categories(place)
        wanted = tuple(name for name in known if self.category is None or same_category(name, self.category))
        if not wanted:
            raise InputError(place.scans, "no scans: run kinmo render --unlabelled first")
        for category in wanted:
            yield TrainScans(place, self.config, category, "supervised", seed=self.seed, device=how[0], workers=how[1])
            yield SelfLabelScans(place, category, load_config(self.config).ancsh.confidence, self.seed, *how)
            yield TrainScans(place, self.config, category, "self-training", seed=self.seed, device=how[0], workers=how[1])
