"""Every table of the paper that there are networks for."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.pipeline.evaluate import Evaluate
from kinmo.pipeline.scan_tables import JudgeTrained
from kinmo.pipeline.stage import Observer, Outcome, Plan


@dataclass(frozen=True)
class EvaluateAll:
    """Table 1, then those of scans; their data are beside the settings of Table 1, by the name of the table."""

    shapes: Evaluate
    scans: JudgeTrained

    def plan(self) -> Plan:
        first, second = self.shapes.plan(), self.scans.plan()
        return Plan(first.steps + second.steps, first.seconds + second.seconds)

    def run(self, observer: Observer) -> Outcome:
        first, second = self.shapes.run(observer), self.scans.run(observer)
        text = "\n".join(filter(None, [first.text, second.text]))
        return Outcome(first.path, {**first.data, **second.data}, text, first.failed + second.failed)
