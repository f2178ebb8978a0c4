"""Small workspaces in which stages have run. Imports stay inside: most tests need neither workspaces nor torch."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from scanned_workspace import Scanned
    from trained_workspace import Trained

    from kinmo.dataset.stage import Stage
    from kinmo.dataset.workspace import Workspace


@contextmanager
def one_thread() -> Iterator[None]:
    """Let torch use one thread, so that results do not depend on the machine."""
    import torch

    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="session")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Trained]:
    """Procedural shapes, prepared, trained on, pseudo-labelled, evaluated and reported on."""
    from trained_workspace import COUNT, FAMILIES, METHODS, Recorder, Trained, tiny_config

    from kinmo.config import load_config
    from kinmo.dataset.workspace import Workspace
    from kinmo.experiments.label_truth import label_truth_tables
    from kinmo.experiments.table1.ablations import AblationRows
    from kinmo.experiments.table1.baselines import PaperBaselines
    from kinmo.pipeline.evaluation.evaluate_shapes import EvaluateShapes
    from kinmo.pipeline.prepare_shapes import Prepare
    from kinmo.pipeline.pseudo_label_shapes import PseudoLabel
    from kinmo.pipeline.train_motion import TrainMotion
    from kinmo.synth.synth_stage import Synth
    from kinmo.view.html_report import Report

    folder = tmp_path_factory.mktemp("trained")
    shapes, workspace, config = folder / "partnet", Workspace(folder / "workspace"), str(tiny_config(folder))
    with one_thread():
        stages: dict[str, Stage] = {
            "synth": Synth(shapes, COUNT, FAMILIES),
            "prepare": Prepare(shapes, workspace),
            "train": TrainMotion("motion", workspace, config, device="cpu"),
            "pseudo-label": PseudoLabel(workspace, threshold=0.0, device="cpu"),
            "eval": EvaluateShapes(
                workspace,
                METHODS,
                baselines=PaperBaselines(load_config(config).refinement),
                more_rows=AblationRows(),
                more_tables=label_truth_tables,
                device="cpu",
            ),
            "report": Report(workspace),
        }
        result = Trained(shapes, workspace, stages)
        for name, stage in stages.items():
            result.outcomes[name] = stage.run(Recorder())
        yield result


@pytest.fixture(scope="session")
def scanned(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scanned]:
    """Objects with and without labels, scans of all of them, and supervised networks."""
    from scanned_workspace import scanned_in

    with one_thread():
        yield scanned_in(tmp_path_factory.mktemp("scans"))


@pytest.fixture
def evaluated(scanned: Scanned, tmp_path: Path) -> Workspace:
    """A copy of the workspace with scans, whose supervised networks are evaluated."""
    from scanned_workspace import FAMILY
    from trained_workspace import Recorder

    from kinmo.dataset.workspace import Workspace
    from kinmo.experiments.scan_tables.evaluate_trained import EvaluateTrained

    EvaluateTrained(scanned.workspace, FAMILY, device="cpu").run(Recorder())
    shutil.copytree(scanned.workspace.path, tmp_path / "workspace")
    return Workspace(tmp_path / "workspace")
