"""Record of all runs of a workspace: the report shows it, and estimates of duration are made from it."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import datetime, timezone

from kinmo._core import __version__
from kinmo.dataset.workspace import Workspace
from kinmo.io.atomic_files import append_line

SMALL_SHARE = 0.1
"""Runs that did less than this share of the largest run do not count for estimates: they measure the start-up."""


@dataclass(frozen=True)
class Run:
    """One finished run of a stage: its start in UTC (ISO 8601), and the work done in the stage's own unit and for people."""

    stage: str
    started: str
    seconds: float
    amount: int
    what: str
    kinmo: str = __version__


class Stopwatch:
    """Filled in while a stage runs: `amount` of work done, and `what` it was, for people."""

    amount = 0
    what = ""


@contextmanager
def timed(workspace: Workspace, stage: str) -> Iterator[Stopwatch]:
    """Record a run when the block ends without an exception and some work was done."""
    watch, started, begin = Stopwatch(), datetime.now(timezone.utc), time.monotonic()
    yield watch
    if watch.amount:
        seconds = round(time.monotonic() - begin, 2)
        run = Run(stage, started.isoformat(timespec="seconds"), seconds, watch.amount, watch.what)
        append_line(workspace.journal, json.dumps(asdict(run), ensure_ascii=False))


def runs(workspace: Workspace) -> list[Run]:
    """All runs, in order. Lines that a killed process left unfinished are skipped."""
    try:
        lines = workspace.journal.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    found = []
    for line in lines:
        try:
            found.append(Run(**json.loads(line)))
        except (ValueError, TypeError):
            continue
    return found


def seconds_per_unit(workspace: Workspace, stage: str, otherwise: float, prefix: str | None = None) -> float:
    """Seconds per unit of a stage's work, in its last run that did a fair amount. `otherwise` if no run is known.

    If the stage never ran, stages whose names begin with `prefix` count.
    """
    known = runs(workspace)
    past = [run for run in known if run.stage == stage]
    if not past and prefix is not None:
        past = [run for run in known if run.stage.startswith(prefix)]
    largest = max((run.amount for run in past), default=0)
    past = [run for run in past if run.amount >= SMALL_SHARE * largest]
    return past[-1].seconds / past[-1].amount if past else otherwise
