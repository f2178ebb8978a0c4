"""When each stage ran and how long it took: what the report shows, and what estimates are made from.

Workspaces that lie in another one have no journal of their own: theirs is the root's, which so knows how long everything takes.
"""

from __future__ import annotations

import io
import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import BinaryIO

from kinmo._core import __version__
from kinmo.dataset.workspace import Workspace

LITTLE = 0.1
"""Of the largest amount that was ever done at once."""


@dataclass(frozen=True)
class Run:
    """One finished run of a stage. `started` is ISO 8601 in UTC; `amount` says how much was done, in the stage's own unit."""

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
    """Add a line to the journal when the block ends well and some work was done."""
    watch, started, begin = Stopwatch(), datetime.now(timezone.utc), time.monotonic()
    yield watch
    if watch.amount:
        seconds = time.monotonic() - begin
        place = "" if workspace.path == workspace.root else f"{workspace.path.relative_to(workspace.root).as_posix()}: "
        run = Run(stage, started.isoformat(timespec="seconds"), round(seconds, 2), watch.amount, place + watch.what)
        with _path(workspace).open("a+b") as lines:
            begun = "\n" if _ends_within_a_line(lines) else ""  # by a process that was killed
            lines.write(f"{begun}{json.dumps(asdict(run), ensure_ascii=False)}\n".encode())


def _ends_within_a_line(file: BinaryIO) -> bool:
    if file.seek(0, io.SEEK_END) == 0:
        return False
    file.seek(-1, io.SEEK_END)
    return file.read(1) != b"\n"


def runs(workspace: Workspace) -> list[Run]:
    """All runs, in order. Lines that a killed process left unfinished are passed over."""
    found = []
    try:
        lines = _path(workspace).read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    for line in lines:
        try:
            found.append(Run(**json.loads(line)))
        except (ValueError, TypeError):
            continue
    return found


def seconds_per_unit(workspace: Workspace, stage: str, otherwise: float, kind: str | None = None) -> float:
    """How long a unit of the stage's work took the last time, or else of a stage whose name begins with `kind`.

    Runs that did little beside the largest one do not count: they tell how long starting takes. `otherwise` if none of these
    ever ran.
    """
    known = runs(workspace)
    past = [run for run in known if run.stage == stage]
    if not past and kind is not None:
        past = [run for run in known if run.stage.startswith(kind)]
    largest = max((run.amount for run in past), default=0)
    past = [run for run in past if run.amount >= LITTLE * largest]
    return past[-1].seconds / past[-1].amount if past else otherwise


def _path(workspace: Workspace) -> Path:
    return workspace.root / "journal.jsonl"
