"""The motion networks: name, section of the configuration, and trainer of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_training import train_motion_gnn
from kinmo.learning.training_loop import FitResult
from kinmo.methods import METHOD_MODELS
from kinmo.methods.kinmo.grouping.grouping_network import KIND as GROUPING
from kinmo.methods.kinmo.grouping.grouping_training import train_part_grouping
from kinmo.methods.kinmo.limits.limits_network import KIND as LIMITS
from kinmo.methods.kinmo.limits.limits_training import train_joint_limits
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
    "limits": ("limits", train_joint_limits),
    "gnn_contact": ("gnn", _train_on_contact_edges),
}
"""Section of the configuration and trainer, by model, in the order of training."""


@dataclass(frozen=True)
class Continuation:
    """Continued training of a model from trained weights.

    Attributes:
        kind: Kind of the weights, which the model's trainer takes as `initial`.
        sizes: Settings that must be equal.
    """

    kind: str
    sizes: tuple[str, ...]


CONTINUED: dict[str, Continuation] = {
    "grouping": Continuation(GROUPING, ("members", "width", "rounds", "word_features")),
    "ranking": Continuation(RANKING, ("members", "width", "word_features")),
    "limits": Continuation(LIMITS, ("width", "word_features")),
}
"""Models that can continue from trained weights."""

GROUPS: dict[str, tuple[str, ...]] = {
    "motion": ("gnn_fine", "gnn_coarse", "axis", *METHOD_MODELS["kinmo"]),
    **METHOD_MODELS,
    "gnn": ("gnn_fine", "gnn_coarse"),
    "axis": ("axis",),
    "contact-edges": ("gnn_contact",),
}
"""Models by group. `motion` serves both methods, a method's name that method, `contact-edges` an ablation."""
