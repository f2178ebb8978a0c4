"""The motion networks: name, section of the configuration, and trainer of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.learning.training_loop import FitResult
from kinmo.methods import METHOD_MODELS
from kinmo.methods.kinmo.grouping.grouping_training import train_part_grouping
from kinmo.methods.kinmo.ranking.ranking_network import KIND as RANKING
from kinmo.methods.kinmo.ranking.ranking_training import train_joint_ranking
from kinmo.methods.paper.axis_selection.axis_selection_training import train_axis_selection

Trainer = Callable[..., FitResult]  # a function such as `train_motion_gnn`


def _train_on_contact_edges(
    training: list[PreparedShape], validation: list[PreparedShape], config: GnnConfig, run_dir: Path, **options: Any
) -> FitResult:
    return train_motion_gnn(training, validation, replace(config, edges="contact"), run_dir, types="fine", **options)


TRAINERS: dict[str, tuple[str, Trainer]] = {
    "gnn_fine": ("gnn", partial(train_motion_gnn, types="fine")),
    "gnn_coarse": ("gnn", partial(train_motion_gnn, types="coarse")),
    "axis": ("axis", train_axis_selection),
    "grouping": ("grouping", train_part_grouping),
    "ranking": ("ranking", train_joint_ranking),
    "gnn_contact": ("gnn", _train_on_contact_edges),
}
"""Section of the configuration and trainer, by model, in the order of training."""

CONTINUED: dict[str, tuple[str, Callable[[Path], Trainer], tuple[str, ...]]] = {
    "ranking": (
        RANKING,
        lambda start: partial(train_joint_ranking, initial=start),
        ("members", "width", "word_features"),
    )
}
"""Models that can continue from trained weights: kind of the weights, trainer, and settings that must be equal."""

GROUPS: dict[str, tuple[str, ...]] = {
    "motion": ("gnn_fine", "gnn_coarse", "axis", "grouping", "ranking"),
    "gnn": ("gnn_fine", "gnn_coarse"),
    "axis": ("axis", "grouping", "ranking"),
    "contact-edges": ("gnn_contact",),
    **METHOD_MODELS,
}
"""Models by group. `motion` serves both methods, a method's name that method, `contact-edges` an ablation."""
