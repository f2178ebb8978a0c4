"""What all stages have in common."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol


class Observer(Protocol):
    """Where a stage tells how far it is."""

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        """`done` of `total` steps of `what` are finished; `detail` is the latest figure or name."""

    def note(self, text: str) -> None:
        """One line that is worth reading afterwards."""

    def problem(self, text: str) -> None:
        """One line on what the user asked for and does not get, which is told however quiet it is to be."""


@dataclass(frozen=True)
class Plan:
    """What a stage would do now, and what it cannot, with the reason.

    `seconds` is a rough guess for this machine; zero where there is nothing to do.
    """

    steps: tuple[str, ...]
    seconds: float
    impossible: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """What a stage made: the `path` to look at, the result itself as plain `data` (JSON), the same as `text` for people.

    `failed` counts what the user asked for and did not get.
    """

    path: Path
    data: Any = field(default_factory=dict)
    text: str = ""
    failed: int = 0


class Stage(Protocol):
    """A piece of work that can say what it would do. Nothing is read or written before one of the two is called."""

    def plan(self) -> Plan: ...

    def run(self, observer: Observer) -> Outcome: ...


class LaterStage(Stage, Protocol):
    """A stage that works on what others leave."""

    def guess(self) -> Plan:
        """What it will do about, where stages before it have not been run yet, or will change what it is done for."""
