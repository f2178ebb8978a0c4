"""Training of the grouping networks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.optim.lr_scheduler import LRScheduler

from kinmo.config import GroupingConfig
from kinmo.core.errors import InputError
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.learner import Learner, adam_options, one_cycle
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import load_weights, save_weights
from kinmo.methods.kinmo.grouping.grouping_batches import GroupingBatch, collate_graphs
from kinmo.methods.kinmo.grouping.grouping_network import (
    KIND,
    GroupingNetwork,
    grouping_loss,
    grouping_networks,
    mean_logits,
)
from kinmo.methods.kinmo.grouping.leaf_graph import LeafGraph, leaf_graph

STANDARDIZATION_GRAPHS = 512
"""Largest number of graphs that mean and scale of the features are computed from."""
VALIDATION_GRAPHS = 32
"""Graphs in a batch of validation."""


def train_part_grouping(
    training: Sequence[PreparedShape],
    validation: Sequence[PreparedShape],
    config: GroupingConfig,
    run_dir: Path,
    *,
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train grouping networks on annotated shapes, with the arguments and results of `train_motion_gnn`.

    Training that starts from `initial` weights has the schedule `config.continued`.

    Raises:
        InputError: `training` or `validation` has no shape with two leaves, or `initial` does not fit.
    """
    graphs = [[graph for shape in shapes if (graph := leaf_graph(shape)) is not None] for shapes in (training, validation)]
    for name, found in zip(("training", "validation"), graphs, strict=True):
        if not found:
            raise InputError(f"{name} shapes", "expected a shape with at least two parts")
    torch.manual_seed(seed)
    start = None if initial is None else load_weights(initial, KIND)
    if start is not None:
        config, fingerprint = replace(config, training=config.continued), fingerprint + start.sha256
    data = GroupingData(graphs[0], graphs[1], config)
    learner = GroupingLearner(config, data)
    if start is not None:
        start.fill(learner.networks)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint, on_progress=on_progress)
    facts: dict[str, Any] = {
        "seed": seed,
        "shapes": len(training),
        "epochs": len(result.history),
        "started_from": None if start is None else start.sha256,
        "error": result.best_error,
        "leaf_features": data.widths[0],
        "pair_features": data.widths[1],
    }
    save_weights(run_dir / "weights.safetensors", learner.networks, KIND, to_table(config), facts)
    return result


class GroupingData:
    """Batches of graphs, in a new order in every epoch, with names and hierarchies hidden at random."""

    def __init__(self, training: Sequence[LeafGraph], validation: Sequence[LeafGraph], config: GroupingConfig) -> None:
        self.training, self.validation, self.config = training, validation, config
        spread = np.linspace(0, len(training) - 1, min(STANDARDIZATION_GRAPHS, len(training))).astype(int)
        self.sample = collate_graphs([training[i] for i in spread])
        self.widths = self.sample.leaves.shape[1], self.sample.contact.shape[1]

    @property
    def words(self) -> torch.Tensor:
        """Hashed words of all names in the training graphs, each once."""
        return torch.tensor(
            sorted({word for graph in self.training for words in graph.words for word in words}), dtype=torch.long
        )

    @property
    def steps(self) -> int:
        """Number of batches per epoch."""
        return math.ceil(len(self.training) / self.config.batch_graphs)

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[GroupingBatch]:
        """Batches of one epoch."""
        for some in np.array_split(rng.permutation(len(self.training)), self.steps):
            yield collate_graphs(
                [self.training[i] for i in some],
                rng=rng,
                hide_names=self.config.hide_names,
                hide_hierarchy=self.config.hide_hierarchy,
                hide_leaf=self.config.hide_leaf_names,
                hide_words=self.config.hide_words,
            )

    def validation_batches(self) -> Iterator[GroupingBatch]:
        """Batches of the validation graphs: once with all that is known, once as flat lists without names."""
        for start in range(0, len(self.validation), VALIDATION_GRAPHS):
            graphs = self.validation[start : start + VALIDATION_GRAPHS]
            yield collate_graphs(graphs)
            yield collate_graphs(graphs, hide_names=1.0, hide_hierarchy=1.0)


class GroupingLearner(Learner):
    """Cross-entropy of every network; the best epoch has the smallest share of wrong pairs, a mean over validation graphs."""

    schedule_every_step = True

    def __init__(self, config: GroupingConfig, data: GroupingData) -> None:
        super().__init__(config.training)
        self.networks = grouping_networks(config, *data.widths)
        for network in self.networks:
            assert isinstance(network, GroupingNetwork)
            network.standardize(data.sample.leaves, data.sample.contact)
            network.silence_unknown_words(data.words)
        self.steps = data.steps * config.training.epochs

    def training_step(self, batch: GroupingBatch) -> torch.Tensor:
        outputs = [network(batch) for network in self.networks]
        losses = torch.stack([grouping_loss(same_body, moves, batch) for same_body, moves in outputs])
        self.log("training", batch.graphs, loss=losses.mean())
        return losses.sum()

    def validation_step(self, batch: GroupingBatch) -> None:
        same_body, moves = mean_logits(self.networks, batch)
        wrong = ((same_body > 0).float() - batch.same_body).abs()
        error = (wrong * batch.weights).sum() / batch.weights.sum().clamp_min(1e-9)
        self.log("validation", batch.graphs, loss=grouping_loss(same_body, moves, batch), error=error)

    def make_optimizer(self) -> torch.optim.Optimizer:
        """AdamW."""
        return torch.optim.AdamW(self.parameters(), **adam_options(self.training_config))

    def make_schedule(self, optimizer: torch.optim.Optimizer) -> LRScheduler:
        """One cycle of the learning rate over the whole training."""
        return one_cycle(optimizer, self.training_config.learning_rate, self.steps)
