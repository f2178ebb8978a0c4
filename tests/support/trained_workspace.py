"""The small trained workspace that tests of many stages share, and tools for it."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.resources import files
from pathlib import Path

from kinmo.dataset.stage import Outcome, Stage
from kinmo.dataset.workspace import Workspace

FAMILIES, COUNT = ("pliers", "stapler"), 4
"""The fewest shapes that leave some for training, for validation and for testing."""
METHODS = ("kinmo", "paper")


@dataclass
class Recorder:
    """Observer that records what it is shown."""

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
class Trained:
    """A workspace in which all stages have run once: the stages by name, in order, and their outcomes."""

    shapes: Path
    workspace: Workspace
    stages: dict[str, Stage]
    outcomes: dict[str, Outcome] = field(default_factory=dict)

    def copy(self, folder: Path) -> Workspace:
        """A copy of the workspace below a folder."""
        shutil.copytree(self.workspace.path, folder / "workspace")
        return Workspace(folder / "workspace")


RESULTS = {
    "train": (
        "models",
        ("train-gnn_fine", "train-gnn_coarse", "train-axis", "train-grouping", "train-ranking", "train-limits"),
    ),
    "pseudo-label": ("pseudo_labels", ("pseudo-label-kinmo",)),
    "eval": ("evaluation", ("evaluate-all",)),
}
"""The folder that a stage fills, and its records."""


def copy_without(trained: Trained, folder: Path, stages: Iterable[str]) -> Workspace:
    """A copy of the workspace in which some stages have not run."""
    workspace = trained.copy(folder)
    for stage in stages:
        made, records = RESULTS[stage]
        for record in records:
            workspace.forget(record)
        shutil.rmtree(workspace.path / made)
    return workspace


TINY = {"epochs": "1", "variants": "4", "batches_per_epoch": "2", "batch_joints": "4"}
"""Settings of the configuration `small` that make training short, by their names."""


def tiny_config(folder: Path) -> Path:
    """The configuration `small` with one epoch of few batches."""
    lines = files("kinmo.config").joinpath("builtin", "small.toml").read_text(encoding="utf-8").splitlines()
    names = [line.partition(" = ")[0] for line in lines]
    path = folder / "tiny.toml"
    short = (f"{name} = {TINY[name]}" if name in TINY else line for name, line in zip(names, lines, strict=True))
    path.write_text("\n".join(short), encoding="utf-8")
    return path


def contents(folder: Path) -> dict[str, str]:
    """Hashes of all files but locks, the journal, and caches (whose lines depend on the order of events)."""
    skipped = (".lock", "journal.jsonl", ".kinmo.jsonl")
    found = (path for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in skipped)
    return {str(path.relative_to(folder)): sha256(path.read_bytes()).hexdigest() for path in found}
