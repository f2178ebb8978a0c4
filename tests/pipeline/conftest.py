"""A workspace that has gone the whole road once, small enough for every test run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

import pytest
import torch

from kinmo.pipeline.evaluate import Evaluate
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.report import Report
from kinmo.pipeline.stage import Outcome, Stage
from kinmo.pipeline.synth import Synth
from kinmo.pipeline.train import Train
from kinmo.workspace import Workspace

FAMILIES = ("laptop", "refrigerator")
METHOD = "paper"


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


@dataclass
class Road:
    """The folders, the stages by name in their order, and what each made."""

    shapes: Path
    workspace: Workspace
    stages: dict[str, Stage]
    outcomes: dict[str, Outcome] = field(default_factory=dict)


def tiny_config(folder: Path) -> Path:
    """The configuration `small` with one epoch."""
    lines = files("kinmo").joinpath("configs", "small.toml").read_text(encoding="utf-8").splitlines()
    path = folder / "tiny.toml"
    path.write_text("\n".join("epochs = 1" if line.startswith("epochs") else line for line in lines), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def road(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Road]:
    folder = tmp_path_factory.mktemp("road")
    shapes, workspace, config = folder / "partnet", Workspace(folder / "workspace"), str(tiny_config(folder))
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    stages: dict[str, Stage] = {
        "synth": Synth(shapes, 10, FAMILIES),
        "prepare": Prepare(shapes, workspace),
        "train": Train("all", workspace, config, device="cpu"),
        "pseudo-label": PseudoLabel(workspace, METHOD, threshold=0.3, device="cpu"),
        "eval": Evaluate(workspace, (METHOD,), device="cpu"),
        "report": Report(workspace),
    }
    made = Road(shapes, workspace, stages)
    for name, stage in stages.items():
        made.outcomes[name] = stage.run(Listener())
    yield made
    torch.set_num_threads(threads)
