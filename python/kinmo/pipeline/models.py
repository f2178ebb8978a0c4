"""The networks of a workspace: what each is called, where it lies, and how it is trained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from kinmo.config import GnnConfig
from kinmo.learning.axis_selection.train import train_axis_selection
from kinmo.learning.joint_ranking.train import train_joint_ranking
from kinmo.learning.motion_gnn.train import train_motion_gnn
from kinmo.learning.training import FitResult, Progress
from kinmo.prepared import PreparedShape
from kinmo.workspace import Workspace

WEIGHTS = "weights.safetensors"
"""Written into a model's folder when its training is done."""
HEADER = "weights.json"
"""What the weights are for, written right after them."""
METRICS = "metrics.json"
"""One entry an epoch, from the first epoch on."""


class Trainer(Protocol):
    """A function such as `train_motion_gnn`; `config` is its section of the configuration."""

    def __call__(
        self,
        training: list[PreparedShape],
        validation: list[PreparedShape],
        config: Any,
        run_dir: Path,
        *,
        seed: int,
        device: str,
        fingerprint: str,
        on_progress: Callable[[Progress], None],
    ) -> FitResult: ...


def _train_on_contact_edges(
    training: list[PreparedShape], validation: list[PreparedShape], config: GnnConfig, run_dir: Path, **options: Any
) -> FitResult:
    return train_motion_gnn(training, validation, replace(config, edges="contact"), run_dir, types="fine", **options)


TRAINERS: dict[str, tuple[str, Trainer]] = {
    "gnn_fine": ("gnn", partial(train_motion_gnn, types="fine")),
    "gnn_coarse": ("gnn", partial(train_motion_gnn, types="coarse")),
    "axis": ("axis", train_axis_selection),
    "ranking": ("ranking", train_joint_ranking),
    "gnn_contact": ("gnn", _train_on_contact_edges),
}
"""The section of the configuration and the trainer of every model, in the order of training."""

GROUPS: dict[str, tuple[str, ...]] = {
    "all": ("gnn_fine", "gnn_coarse", "axis", "ranking"),
    "gnn": ("gnn_fine", "gnn_coarse"),
    "axis": ("axis", "ranking"),
    "contact-edges": ("gnn_contact",),
}
"""What `kinmo train` calls them; `all` is what the two methods need, the rest is for ablations."""


def group_of(model: str) -> str:
    """What to train for a model: the first group that has it."""
    return next(group for group, models in GROUPS.items() if model in models)


def model_folder(workspace: Workspace, model: str, category: str | None = None) -> Path:
    """Where a model lies; models of a single category have a folder each."""
    return workspace.models / model / category if category else workspace.models / model


def weights_for(workspace: Workspace, model: str, category: str) -> Path | None:
    """The trained weights for a shape of `category`: those of the category alone, else those of all, else None."""
    for folder in (model_folder(workspace, model, category), model_folder(workspace, model)):
        if (folder / WEIGHTS).exists():
            return folder / WEIGHTS
    return None
