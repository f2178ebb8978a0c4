"""Progress on stderr: bars on a terminal, occasional lines elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType

SECONDS_BETWEEN_LINES = 10.0


class QuietObserver:
    """Shows problems alone."""

    def __enter__(self) -> QuietObserver:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        pass

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        pass

    def note(self, text: str) -> None:
        pass

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


class BarObserver(QuietObserver):
    """Shows a bar for each thing in progress, for terminals."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._bars = Progress(
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn(),
            TextColumn("{task.fields[detail]}", markup=False), console=Console(stderr=True), refresh_per_second=4,
        )  # fmt: skip
        self._tasks: dict[str, int] = {}

    def __enter__(self) -> BarObserver:
        self._bars.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bars.stop()

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        from rich.progress import TaskID

        if what not in self._tasks:
            self._tasks[what] = int(self._bars.add_task(what, total=total, detail=""))
        self._bars.update(TaskID(self._tasks[what]), completed=done, total=total, detail=detail)

    def note(self, text: str) -> None:
        self._bars.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def problem(self, text: str) -> None:
        self.note(text)


def observer(quiet: bool) -> QuietObserver:
    """Observer for the kind of stderr."""
    if quiet:
        return QuietObserver()
    return BarObserver() if sys.stderr.isatty() else LineObserver()
