"""The stage `eval FILES --truth FOLDER`: it scores URDF files of any tool against annotated shapes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from kinmo.core.categories import same_category
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.wording import counted
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.workspace import Workspace
from kinmo.evaluation.tables import Caption, as_text, write_table
from kinmo.evaluation.urdf_scoring import score_urdf_folder, summarise_urdf_scores, urdf_failures_table, urdf_table
from kinmo.evaluation.urdf_scoring.urdf_folders import write_json
from kinmo.io.discover import discover
from kinmo.io.readers import PARTNET_MOBILITY

URDF_FILES = "urdf_files"  # folder of the scores of URDF files, below the evaluations of the workspace
SECONDS_PER_SHAPE = 1.0  # estimate, for one CPU core


@dataclass(frozen=True)
class ScoreUrdfs:
    """Score URDF files against annotated shapes."""

    predictions: Path  # folder with the URDF files, each named after a shape or in a folder named after it
    truth: Path  # folder with the annotated shapes, in PartNet-Mobility's layout
    workspace: Workspace  # gets the scores
    category: str | None = None
    workers: int = 1

    def plan(self) -> Plan:
        """Count the annotated shapes."""
        count = sum(found.layout == PARTNET_MOBILITY for found in discover(self.truth))
        step = f"score the URDFs below {self.predictions} for up to {counted(count, 'shape')} below {self.truth}"
        return Plan((step,), count * SECONDS_PER_SHAPE / self.workers)

    def run(self, observer: Observer) -> Outcome:
        """Score the files, and write the tables."""
        caption = Caption("URDF files", str(self.predictions), 0, 0, f"{self.category or 'all'} of {self.truth}", ())
        folder = self.workspace.evaluation / URDF_FILES
        with self.workspace.locked():
            report = score_urdf_folder(
                self.predictions,
                self.truth,
                ids=self._ids(observer),
                workers=self.workers,
                progress=partial(observer.progress, "scoring URDFs"),
            )
            for reason in report.unreadable.values():
                observer.problem(f"skipped: {reason}")
            for scored in report.objects:
                if scored.reason:
                    observer.problem(f"failed: {scored.id}: {scored.reason}")
            summary = summarise_urdf_scores(report)
            table = urdf_table(summary, report, caption)
            failures = urdf_failures_table(report, replace(caption, title="URDF files that were not scored"))
            write_table(table, folder, "by_category")
            write_table(failures, folder, "failures")
            write_json(folder.with_suffix(".json"), summary)
        return Outcome(folder, summary, as_text(table), failed=0 if report.objects else len(report.unreadable))

    def _ids(self, observer: Observer) -> list[str] | None:
        """Ids of the shapes of the category; None for all. Raises InputError if there is none."""
        if self.category is None:
            return None
        categories: dict[str, str] = {}
        for found in discover(self.truth):
            if found.layout == PARTNET_MOBILITY and found.id not in categories:
                try:
                    categories[found.id] = found.read().category
                except InputError as error:
                    observer.problem(f"skipped: {error}")
        ids = [name for name, category in categories.items() if same_category(category, self.category)]
        if not ids:
            known = sorted(set(categories.values()))
            near = did_you_mean(self.category, known)
            raise InputError(self.truth, f"no shape of {self.category}{near}; there are {', '.join(known) or 'none'}")
        return ids
