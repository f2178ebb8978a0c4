"""Training of the motion GNN (paper, section 3.2)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import torch

from kinmo.config import GnnConfig
from kinmo.core.errors import InputError
from kinmo.core.motion_types import MotionType
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.learner import Learner
from kinmo.learning.motion_gnn.gnn_batches import GraphData, used_edges
from kinmo.learning.motion_gnn.gnn_loss import class_weights, classes_of, edge_losses
from kinmo.learning.motion_gnn.gnn_network import CLASSES, KIND, MotionGnn, TypeSet
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch
from kinmo.learning.training_loop import FitResult, Progress, fit
from kinmo.learning.weights import load_weights, save_weights

ERRORS = ("type_error", "rest_error", "direction_error", "pivot_error")
"""Validation metrics whose sum decides which epoch is the best."""


def train_motion_gnn(
    training: Sequence[PreparedShape],
    validation: Sequence[PreparedShape],
    config: GnnConfig,
    run_dir: Path,
    *,
    types: TypeSet = "fine",
    seed: int = 0,
    device: str = "auto",
    fingerprint: str = "",
    on_progress: Callable[[Progress], None] | None = None,
    initial: Path | None = None,
) -> FitResult:
    """Train a motion GNN and write `weights.safetensors` and `weights.json` of the kept epoch.

    Args:
        training: Annotated shapes to train on.
        validation: Annotated shapes to choose the best epoch by.
        config: Configuration of the network and its training.
        run_dir: Folder for the results. An interrupted training there is resumed (`kinmo.learning.training_loop.fit`).
        types: "fine" for the ten motion types, "coarse" for the five without orientation and place of the axis.
        seed: Seed of everything random.
        device: "cpu", "cuda", "mps", or "auto".
        fingerprint: Hash of the data, which a checkpoint must agree with to be resumed.
        on_progress: Called after every epoch.
        initial: Weights of an earlier training with the same sizes, to start from.

    Raises:
        InputError: `training` or `validation` has no edge to learn from, `initial` does not fit the configuration, or the
            training fails (`fit`).
    """
    for name, shapes in (("training", training), ("validation", validation)):
        if not any(len(used_edges(shape, config)) for shape in shapes):
            where = "below the same node" if config.edges == "siblings" else "in contact"
            raise InputError(f"{name} shapes", f"expected a shape with two parts {where}")
    data = GraphData(training, validation, config)
    torch.manual_seed(seed)
    learner = GnnLearner(config, CLASSES[types], data.labels)
    if initial is not None:
        load_weights(initial, KIND).fill(learner.network)
    result = fit(learner, data, run_dir, seed=seed, device=device, fingerprint=fingerprint + types, on_progress=on_progress)
    facts = {"types": types, "seed": seed, "shapes": len(training), "epochs": len(result.history), "error": result.best_error}
    save_weights(run_dir / "weights.safetensors", learner.network, KIND, to_table(config), facts)
    return result


class GnnLearner(Learner):
    """A motion GNN with its loss L (paper, section 3.2).

    The validation error is the sum of `ERRORS`. These are the share of wrong types among motion edges, the same share among all
    other edges, the mean direction error (undirected, ||d -+ d^||) and the mean pivot error. The sum has the terms of the loss,
    but over-confident probabilities do not inflate it. The class weights depend on `labels`, the fine types of all training
    edges [E].
    """

    def __init__(self, config: GnnConfig, classes: int, labels: torch.Tensor) -> None:
        super().__init__(config.training)
        self.classes = classes
        self.network = MotionGnn(config, classes)
        self.class_weights: torch.Tensor | None
        self.register_buffer("class_weights", class_weights(labels, classes, config.class_balance))

    def training_step(self, batch: GraphBatch) -> torch.Tensor:
        graph = batch.graph
        output = self.network(batch)
        losses = edge_losses(output, graph.types, graph.directions, graph.pivots, self.class_weights)
        self.log("training", len(graph.types), loss=losses.total)
        return losses.total

    def validation_step(self, batch: GraphBatch) -> None:
        graph = batch.graph
        output = self.network(batch)
        losses = edge_losses(output, graph.types, graph.directions, graph.pivots, self.class_weights, undirected=True)
        wrong = (output.logits.argmax(1) != classes_of(graph.types, self.classes)).float()
        moves = graph.types < MotionType.FIXED
        self.log("validation", len(wrong), loss=losses.total, edge_accuracy=1.0 - wrong.mean())
        if (~moves).any():
            self.log("validation", int((~moves).sum()), rest_error=wrong[~moves].mean())
        if moves.any():
            motion = {"type_error": wrong[moves].mean(), "direction_error": losses.direction, "pivot_error": losses.pivot}
            self.log("validation", int(moves.sum()), **motion)

    def validation_error(self, means: Mapping[str, torch.Tensor]) -> torch.Tensor:
        names = (f"validation/{name}" for name in ERRORS)
        return sum((means[name] for name in names if name in means), torch.tensor(0.0))
