"""The stage `prepare`: it checks and converts every shape below a folder."""

from __future__ import annotations

import re
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import counted, printable_path
from kinmo.dataset.folder_preparation import ORACLE, PreparationReport, count_shapes, prepare_folder
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import write_json_atomically

STAGE = "prepare"
REPORT = "report.json"  # file beside the index that lists the outcome for every shape
SECONDS_PER_SHAPE = 0.25  # first estimate, for one CPU core
MAX_LINES = 40  # skipped shapes that are listed on the terminal; the report has all of them


@dataclass(frozen=True)
class Prepare:
    """Prepare every shape below a folder."""

    root: Path
    workspace: Workspace
    workers: int = 1
    seed: int = 0
    oracle: tuple[Path, ...] = ()  # folders whose labels are oracle labels: nothing is trained on them
    cluster: str | None = None  # address of a Ray cluster that runs the jobs; None for this machine

    def plan(self) -> Plan:
        """Count the shapes; unchanged ones are only checked."""
        count = count_shapes(self.root, self.workspace)
        each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_SHAPE / self.workers)
        step = f"check {counted(count, 'shape')} below {self.root}, and prepare new and changed ones"
        return Plan((step,), count * each)

    def run(self, observer: Observer) -> Outcome:
        """Prepare new and changed shapes, and write the index."""
        below = printable_path(self.root)
        for folder in filter(Path.is_dir, [*self.root.glob(ORACLE), *self.root.glob(f"*/{ORACLE}")]):  # of kinmo synth
            if not any(folder.resolve().is_relative_to(given.resolve()) for given in self.oracle):
                use = f"included as labelled shapes; with --oracle {folder} nothing is trained on their labels"
                observer.note(f"{folder}: {use}")
        before: set[str] = set()
        with suppress(InputError):  # nothing is prepared yet, or the index cannot be read
            before = {entry.source for entry in PreparedStore(self.workspace.prepared).entries}
        with timed(self.workspace, STAGE) as watch:
            report = prepare_folder(
                self.root,
                self.workspace,
                workers=self.workers,
                seed=self.seed,
                oracle=self.oracle,
                cluster=self.cluster,
                on_progress=partial(observer.progress, "preparing shapes"),
            )
            watch.amount, watch.what = report.new, f"{counted(report.new, 'shape')} below {below}"
        entries = PreparedStore(self.workspace.prepared).entries
        oracle = [Path(entry.source).resolve() for entry in entries if entry.is_oracle]
        for folder in self.oracle:
            if not any(path.is_relative_to(folder.resolve()) for path in oracle):
                missing = "no shape at or below it was prepared, so there are no oracle labels from it"
                observer.note(f"{printable_path(folder)}: {missing}")
        if gone := len(before - {entry.source for entry in entries}):
            observer.note(f"{counted(gone, 'earlier shape')} not found below {below}: removed from the workspace")
        data = report.as_data()
        write_json_atomically(self.workspace.prepared / REPORT, data)
        usable = len(report.included) + len(report.repaired)
        if not usable and report.skipped:
            observer.problem(f"no shape could be prepared: {report.skipped[0].reasons[0]}")
        return Outcome(self.workspace.prepared, data, summary(report), failed=0 if usable else 1)


def summary(report: PreparationReport) -> str:
    """Table of the numbers of included, repaired and skipped shapes, with the reasons."""
    lines = [f"included  {len(report.included):6}", f"repaired  {len(report.repaired):6}"]
    reasons = Counter(_kind(reason) for entry in report.repaired for reason in entry.reasons)
    lines += [f"{count:16}  {reason}" for reason, count in reasons.most_common(MAX_LINES)]
    lines.append(f"skipped   {len(report.skipped):6}")
    lines += [f"            {reason}" for entry in report.skipped[:MAX_LINES] for reason in entry.reasons[:1]]
    if len(report.skipped) > MAX_LINES:
        lines.append(f"            and {len(report.skipped) - MAX_LINES} more; {REPORT} and --json list all")
    return "\n".join(lines)


def _kind(reason: str) -> str:
    """A repair without the details that differ from shape to shape: names in brackets, and numbers."""
    general = re.sub(r"^joint of [^:]*: ", "joint: ", reason)
    return re.sub(r"\d+([.e+-]+\d+)*(, \d+)*", "#", re.sub(r" \([^)]*\)", "", general))
