"""The stage `eval`: every table of the paper that there are networks for."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained
from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
from kinmo.pipeline.scans.scan_networks import trained_runs


@dataclass(frozen=True)
class EvaluateAll:
    """Evaluate shapes (Table 1), then scans (Tables 2 to 4). If there are networks for scans, Table 1 may be missing."""

    shapes: EvaluateShapes
    scans: EvaluateTrained

    def plan(self) -> Plan:
        """List the scores that are not up to date."""
        first = Plan((), 0.0) if self._problem() else self.shapes.plan()
        second = self.scans.plan()
        return Plan(first.steps + second.steps, first.seconds + second.seconds)

    def run(self, observer: Observer) -> Outcome:
        """Write all tables."""
        problem = self._problem()
        if problem is not None:
            observer.note(f"no Table 1: {problem}")
            return self.scans.run(observer)
        first, second = self.shapes.run(observer), self.scans.run(observer)
        text = "\n".join(filter(None, [first.text, second.text]))
        return Outcome(second.path, {**first.data, **second.data}, text, first.failed + second.failed)

    def _problem(self) -> InputError | None:
        """The reason why there can be no Table 1. It is raised if there are no networks for scans either."""
        category = self.scans.category
        try:
            self.shapes.plan()
        except InputError as error:
            if any(category is None or same_category(run.category, category) for run in trained_runs(self.scans.workspace)):
                return error
            raise
        return None
