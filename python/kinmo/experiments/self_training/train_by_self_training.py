"""The stage `train ancsh --setting self-training`: supervised networks, their labels, and networks trained on these."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from kinmo.config import load_config
from kinmo.core.errors import InputError
from kinmo.dataset.stage import LaterStage, Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.self_training.self_label_scans import SelfLabelScans
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.scan_dataset import scanned_categories
from kinmo.pipeline.scans.train_scans import TrainScans
from kinmo.pipeline.scans.training_settings import Setting


@dataclass(frozen=True)
class TrainBySelfTraining:
    """Train supervised networks, label scans of unlabelled objects with them, and train networks on both."""

    workspace: Workspace
    config: str
    category: str | None = None  # None for all scanned ones
    seed: int = 0
    device: str = "auto"
    workers: int = 1

    def plan(self) -> Plan:
        """List what is left to do; estimate stages whose inputs will change."""
        first, *labelling, last = self._stages()
        plans = [first.plan()]
        plans += [stage.guess() if plans[0].steps else stage.plan() for stage in labelling]
        plans.append(last.guess() if any(plan.steps for plan in plans) else last.plan())
        return Plan(tuple(step for plan in plans for step in plan.steps), sum(plan.seconds for plan in plans))

    def run(self, observer: Observer) -> Outcome:
        """Run all stages. Missing scans to label are reported before anything is trained."""
        stages = list(self._stages())
        for stage in stages:
            if isinstance(stage, SelfLabelScans):
                stage.guess()
        outcomes = [stage.run(observer) for stage in stages]
        return outcomes[-1]

    def _stages(self) -> Iterator[LaterStage]:
        categories = scanned_categories(self.workspace) if self.category is None else (self.category,)
        if not categories:
            raise InputError(self.workspace.scans, "no scans: run kinmo render --unlabelled first")
        confidence = load_config(self.config).ancsh.confidence
        yield self._training("supervised")
        for category in categories:
            yield SelfLabelScans(self.workspace, category, confidence, self.seed, self.device, self.workers)
        yield self._training("self-training")

    def _training(self, setting: Setting) -> TrainScans:
        how = DEFAULT_METHOD, self.seed, self.device, self.workers
        return TrainScans(self.workspace, self.config, self.category, setting, *how)
