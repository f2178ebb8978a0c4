"""What the tests of the stages share."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.resources import files
from pathlib import Path

from kinmo.dataset.stage import Outcome, Stage
from kinmo.dataset.workspace import Workspace

FAMILIES, COUNT = ("laptop", "stapler"), 4
"""The fewest that leave shapes to train on, to choose by, and to test."""
METHODS = ("kinmo", "paper")


@dataclass
class Listener:
    """Remembers what it was told."""

    steps: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def progress(self, what: str, done: int, total: int, detail: str = "") -> None:
        assert 0 < done <= total
        self.steps.append(what)

    def note(self, text: str) -> None:
        self.notes.append(text)

    def problem(self, text: str) -> None:
        self.notes.append(text)


@dataclass
class Road:
    """The folders, the stages by name in their order, and what each made."""

    shapes: Path
    workspace: Workspace
    stages: dict[str, Stage]
    outcomes: dict[str, Outcome] = field(default_factory=dict)


MADE = {
    "train": ("models", ("train-gnn_fine", "train-gnn_coarse", "train-axis", "train-ranking")),
    "pseudo-label": ("pseudo", ("pseudo-label",)),
    "eval": ("eval", ("eval-all",)),
}
"""The folder that a stage fills, and its records."""


def undone(road: Road, folder: Path, stages: Iterable[str]) -> Workspace:
    """A copy of the workspace in which some stages have not run."""
    shutil.copytree(road.workspace.path, folder / "workspace")
    workspace = Workspace(folder / "workspace")
    for stage in stages:
        made, records = MADE[stage]
        for record in records:
            workspace.forget(record)
        shutil.rmtree(workspace.path / made)
    return workspace


def tiny_config(folder: Path) -> Path:
    """The configuration `small` with one epoch."""
    lines = files("kinmo").joinpath("configs", "small.toml").read_text(encoding="utf-8").splitlines()
    path = folder / "tiny.toml"
    path.write_text("\n".join("epochs = 1" if line.startswith("epochs") else line for line in lines), encoding="utf-8")
    return path


def contents(folder: Path) -> dict[str, str]:
    """Digests of all files but the journal."""
    found = (path for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in (".lock", "journal.jsonl"))
    return {str(path.relative_to(folder)): sha256(path.read_bytes()).hexdigest() for path in found}
