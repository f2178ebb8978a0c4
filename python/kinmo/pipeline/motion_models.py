"""The networks of a workspace: what each is called, and how it is trained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.learning.training_loop import FitResult, Progress
from kinmo.methods import METHOD_MODELS
from kinmo.methods.kinmo.ranking.ranking_network import KIND as RANKING
from kinmo.methods.kinmo.ranking.ranking_training import train_joint_ranking
from kinmo.methods.paper.axis_selection.axis_training import train_axis_selection


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

CONTINUED: dict[str, tuple[str, Callable[[Path], Trainer], tuple[str, ...]]] = {
    "ranking": (
        RANKING,
        lambda start: partial(train_joint_ranking, initial=start),
        ("members", "width", "word_features"),
    )
}
"""Of the models that can go on from trained weights: the kind of those, the trainer, and the sizes that must be the same."""

GROUPS: dict[str, tuple[str, ...]] = {
    "motion": ("gnn_fine", "gnn_coarse", "axis", "ranking"),
    "gnn": ("gnn_fine", "gnn_coarse"),
    "axis": ("axis", "ranking"),
    "contact-edges": ("gnn_contact",),
    **METHOD_MODELS,
}
"""What `kinmo train` calls them: `motion` is what both methods need, one what has its name; the rest is for ablations."""
