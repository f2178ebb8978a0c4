"""The common interface of all stages, such as preparing shapes, training or predicting."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol


class Observer:
    """Receiver of a stage's progress and messages. Subclasses show them."""

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        """Show that `done` of `total` steps of `what` are finished; `detail` is the latest figure or name."""

    def note(self, text: str) -> None:
        """Show one line of information."""

    def problem(self, text: str) -> None:
        """Show one line about something that the user asked for and does not get, even if output is to be quiet."""


class SilentObserver(Observer):
    """Observer that shows nothing."""


@dataclass(frozen=True)
class Plan:
    """Work that a stage would do now.

    Attributes:
        steps: one line per step; empty if everything is up to date.
        seconds: rough estimate for this machine; 0 if there is nothing to do.
        impossible: one line for each part that cannot be done, with the reason.
        failed: number of things that the user asked for and would not get.
    """

    steps: tuple[str, ...]
    seconds: float
    impossible: tuple[str, ...] = ()
    failed: int = 0


@dataclass(frozen=True)
class Outcome:
    """Result of a stage.

    Attributes:
        path: file or folder to look at. None if there is none.
        data: the result as plain data, which JSON can hold.
        text: the result for people.
        failed: number of things that the user asked for and did not get.
    """

    path: Path | None
    data: Any = field(default_factory=dict)
    text: str = ""
    failed: int = 0


class Stage(Protocol):
    """A resumable piece of work. Nothing is read or written before `plan` or `run` is called."""

    def plan(self) -> Plan:
        """Find out what is left to do."""

    def run(self, observer: Observer) -> Outcome:
        """Do what is left to do."""


class LaterStage(Stage, Protocol):
    """A stage that works on the results of other stages."""

    def guess(self) -> Plan:
        """Estimate the work while the stages before it have not been run, or will change its inputs."""
