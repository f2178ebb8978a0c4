"""Every table of the paper that there are networks for."""

from __future__ import annotations

from dataclasses import dataclass

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.pipeline.scans.scan_networks import trained_by_all_methods


@dataclass(frozen=True)
class EvaluateAll:
    """Table 1, then those of scans; their data are beside the settings of Table 1, by the name of the table.

    Where there are networks for scans, Table 1 may be missing for a reason that is told.
    """

    shapes: Evaluate
    scans: JudgeTrained

    def plan(self) -> Plan:
        first = Plan((), 0.0) if self._problem() else self.shapes.plan()
        second = self.scans.plan()
        return Plan(first.steps + second.steps, first.seconds + second.seconds)

    def run(self, observer: Observer) -> Outcome:
        problem = self._problem()
        if problem is not None:
            observer.note(f"no Table 1: {problem}")
            return self.scans.run(observer)
        first, second = self.shapes.run(observer), self.scans.run(observer)
        text = "\n".join(filter(None, [first.text, second.text]))
        return Outcome(second.path, {**first.data, **second.data}, text, first.failed + second.failed)

    def _problem(self) -> InputError | None:
        """Why there can be no Table 1. Raised if there are no networks for scans of what is asked for either."""
        category = self.scans.category
        try:
            self.shapes.plan()
        except InputError as error:
            trained = trained_by_all_methods(self.scans.workspace)
            if not any(category is None or same_category(cell.category, category) for _, cell in trained):
                raise
            return error
        return None
