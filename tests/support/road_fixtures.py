"""A workspace that has gone the whole road once, small enough for every test run."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from scan_road import FAMILY, Scanned, made_in
from whole_road import COUNT, FAMILIES, METHODS, Listener, Road, tiny_config

from kinmo.dataset.stage import Stage
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.scan_tables.evaluate_trained import JudgeTrained
from kinmo.experiments.table1.evaluate_table1 import Evaluate
from kinmo.pipeline.prepare import Prepare
from kinmo.pipeline.pseudo_label import PseudoLabel
from kinmo.pipeline.train_motion import Train
from kinmo.synth.synth_stage import Synth
from kinmo.view.report import Report


@pytest.fixture(scope="session")
def road(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Road]:
    folder = tmp_path_factory.mktemp("road")
    shapes, workspace, config = folder / "partnet", Workspace(folder / "workspace"), str(tiny_config(folder))
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    stages: dict[str, Stage] = {
        "synth": Synth(shapes, COUNT, FAMILIES),
        "prepare": Prepare(shapes, workspace),
        "train": Train("motion", workspace, config, device="cpu"),
        "pseudo-label": PseudoLabel(workspace, threshold=0.0, device="cpu"),
        "eval": Evaluate(workspace, METHODS, device="cpu"),
        "report": Report(workspace),
    }
    made = Road(shapes, workspace, stages)
    for name, stage in stages.items():
        made.outcomes[name] = stage.run(Listener())
    yield made
    torch.set_num_threads(threads)


@pytest.fixture(scope="session")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scanned]:
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield made_in(tmp_path_factory.mktemp("scans"))
    torch.set_num_threads(threads)


@pytest.fixture
def judged(scanned: Scanned, tmp_path: Path) -> Workspace:
    """A workspace of one's own, whose supervised networks are judged."""
    JudgeTrained(scanned.workspace, FAMILY, device="cpu").run(Listener())
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    return Workspace(tmp_path / "workspace")
