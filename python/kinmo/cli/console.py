"""Progress on stderr: bars on a terminal, occasional lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from kinmo.dataset.stage import Observer, SilentObserver

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

SECONDS_BETWEEN_LINES = 10.0


class QuietObserver(SilentObserver):
    """Shows problems alone."""

    def problem(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)


class LineObserver(QuietObserver):
    """Shows one line when something starts and ends, and every ten seconds between, for logs."""

    def __init__(self) -> None:
        self._last: dict[str, float] = {}

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        now = time.monotonic()
        if what not in self._last or done >= total or now - self._last[what] > SECONDS_BETWEEN_LINES:
            self._last[what] = now
            self.note(f"{what}: {done}/{total} {detail}".rstrip())

    def note(self, text: str) -> None:
        print(text, file=sys.stderr, flush=True)


class BarObserver(Observer):
    """Shows a bar for each thing in progress, for terminals."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, TaskID] = {}

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        if what not in self._tasks:
            self._tasks[what] = self._bars.add_task(what, total=total, detail="")
        self._bars.update(self._tasks[what], completed=done, total=total, detail=detail)

    def note(self, text: str) -> None:
        self._bars.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def problem(self, text: str) -> None:
        self.note(text)


@contextmanager
def observer(quiet: bool) -> Iterator[Observer]:
    """Observer for the kind of stderr."""
    if quiet or not sys.stderr.isatty():
        yield QuietObserver() if quiet else LineObserver()
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

    with Progress(
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn(),
        TextColumn("{task.fields[detail]}", markup=False), console=Console(stderr=True), refresh_per_second=4,
    ) as bars:  # fmt: skip
        yield BarObserver(bars)
