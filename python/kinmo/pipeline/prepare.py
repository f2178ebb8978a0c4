"""From a folder of shapes to the prepared shapes of the workspace."""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.wording import counted
from kinmo.dataset.folder_preparation import HELD_BACK, PrepareReport, prepare_folder
from kinmo.dataset.journal import seconds_per_unit, timed
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.readers import discover
from kinmo.io.readers.sources import shown

STAGE = "prepare"
REPORT = "report.json"
"""Beside the index: what was taken, repaired and left out."""
SECONDS_PER_SHAPE = 0.25
"""On one core, until the journal knows better."""
LINES = 40
"""Of shapes left out that are listed; all of them are in the report."""


@dataclass(frozen=True)
class Prepare:
    """Prepare every shape below `root`; no network learns from the labels of those below `hold_back`."""

    root: Path
    workspace: Workspace
    workers: int = 1
    seed: int = 0
    hold_back: tuple[Path, ...] = ()

    def plan(self) -> Plan:
        count = sum(1 for _ in discover(self.root, skip=(self.workspace.path,)))
        each = seconds_per_unit(self.workspace, STAGE, SECONDS_PER_SHAPE / self.workers)
        step = f"check {counted(count, 'shape')} below {self.root}, and prepare those that are new or changed"
        return Plan((step,), count * each)

    def run(self, observer: Observer) -> Outcome:
        self._warn_of_held_back(observer)
        before = _sources(self.workspace)
        with timed(self.workspace, STAGE) as watch:
            report = prepare_folder(
                self.root,
                self.workspace,
                workers=self.workers,
                seed=self.seed,
                hold_back=self.hold_back,
                on_progress=lambda done, total, name: observer.progress("preparing shapes", done, total, name),
            )
            watch.amount, watch.what = report.made, f"{counted(report.made, 'shape')} below {shown(self.root)}"
        self._tell_of_nothing_held_back(observer)
        if gone := len(before - _sources(self.workspace)):
            observer.note(f"{gone} shapes of the last time are not among these: the workspace no longer has them")
        data = report.as_data()
        write_text_atomically(self.workspace.prepared / REPORT, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
        usable = len(report.taken) + len(report.repaired)
        if not usable and report.left_out:
            observer.problem(f"nothing could be prepared: {report.left_out[0].reasons[0]}")
        return Outcome(self.workspace.prepared, data, summary(report), failed=0 if usable else 1)

    def _warn_of_held_back(self, observer: Observer) -> None:
        """Of labels that kinmo synth has written to be held back, where nothing holds them back."""
        for folder in filter(Path.is_dir, [*self.root.glob(HELD_BACK), *self.root.glob(f"*/{HELD_BACK}")]):
            if not any(folder.resolve().is_relative_to(given.resolve()) for given in self.hold_back):
                observer.note(f"{folder}: taken as labelled shapes; --hold-back {folder} keeps their labels from all networks")

    def _tell_of_nothing_held_back(self, observer: Observer) -> None:
        """Of folders to hold back that no shape is at or below."""
        entries = PreparedStore(self.workspace.prepared).entries
        held_back = [Path(entry.source).resolve() for entry in entries if entry.is_held_back]
        for folder in self.hold_back:
            if not any(path.is_relative_to(folder.resolve()) for path in held_back):
                observer.note(f"{shown(folder)}: no shape at or below it was prepared, so none is held back")


def _sources(workspace: Workspace) -> set[str]:
    """Where the shapes of the workspace were read from; none if nothing was prepared yet, or the index is not whole."""
    try:
        return {entry.source for entry in PreparedStore(workspace.prepared).entries}
    except InputError:
        return set()


def summary(report: PrepareReport) -> str:
    """The table for people: how many shapes were taken, repaired and left out, and why."""
    lines = [f"taken     {len(report.taken):6}", f"repaired  {len(report.repaired):6}"]
    reasons = Counter(_kind(reason) for entry in report.repaired for reason in entry.reasons)
    lines += [f"{count:16}  {reason}" for reason, count in reasons.most_common(LINES)]
    lines.append(f"left out  {len(report.left_out):6}")
    lines += [f"            {reason}" for entry in report.left_out[:LINES] for reason in entry.reasons[:1]]
    if len(report.left_out) > LINES:
        lines.append(f"            and {len(report.left_out) - LINES} more: all are in {REPORT}, and in what --json prints")
    return "\n".join(lines)


def _kind(reason: str) -> str:
    """A repair without what differs from shape to shape: names in brackets, and numbers."""
    general = re.sub(r"^joint of [^:]*: ", "joint: ", reason)
    return re.sub(r"\d+([.e+-]+\d+)*(, \d+)*", "#", re.sub(r" \([^)]*\)", "", general))
