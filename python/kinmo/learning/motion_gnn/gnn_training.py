"""Training the motion GNN."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import torch

from kinmo.config import GnnConfig
from kinmo.core.joint import MotionType
from kinmo.core.typed_tables import to_table
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_batches import GraphData
from kinmo.learning.motion_gnn.gnn_loss import COARSE_OF_FINE, class_weights, edge_losses
from kinmo.learning.motion_gnn.gnn_network import CLASSES, KIND, EdgeOutput, MotionGnn, TypeSet
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch
from kinmo.learning.training_loop import MONITOR, FitResult, Learner, Progress, fit
from kinmo.learning.weights import load_weights, save_weights


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
    """Train on annotated shapes; leaves `weights.safetensors` and `.json` of the best epoch on `validation` in `run_dir`.

    `fine` learns the ten motion types, `coarse` the five without orientation and place. `initial` are weights of an earlier
    training with the same sizes to start from. Resumes what was cut off (`training.fit`). Raises InputError if `initial` does
    not fit.
    """
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
    """What the loop optimises (L, section 3.2) and by what the best epoch is chosen.

    The latter is the share of wrong types among motion edges plus that among the others, plus the mean error of direction
    (undirected, ||d -+ d^||) and of place: the same sum as the loss, with errors that over-confidence does not inflate.
    """

    def __init__(self, config: GnnConfig, classes: int, labels: torch.Tensor) -> None:
        super().__init__(config.training)
        self.config, self.classes = config, classes
        self.network = MotionGnn(config, classes)
        weights = class_weights(labels, classes, config.class_weights, config.class_balance)
        self.class_weights: torch.Tensor | None
        self.register_buffer("class_weights", weights)

    def forward(self, batch: GraphBatch) -> EdgeOutput:
        return self.network(batch)  # type: ignore[no-any-return]

    def training_step(self, batch: GraphBatch, index: int) -> torch.Tensor:
        graph = batch.graph
        losses = edge_losses(
            self(batch), graph.types, graph.directions, graph.pivots, self.class_weights, self.config.direction_loss
        )
        self._log("training", len(graph.types), loss=losses.total)
        return losses.total

    def validation_step(self, batch: GraphBatch, index: int) -> None:
        graph = batch.graph
        output = self(batch)
        losses = edge_losses(output, graph.types, graph.directions, graph.pivots, self.class_weights, "undirected")
        targets = graph.types if self.classes == len(MotionType) else COARSE_OF_FINE.to(graph.types.device)[graph.types]
        wrong = (output.logits.argmax(1) != targets).float()
        moves = graph.types < MotionType.FIXED
        self._log("validation", len(wrong), loss=losses.total, edge_accuracy=1.0 - wrong.mean())
        if (~moves).any():
            self._log("validation", int((~moves).sum()), rest_error=wrong[~moves].mean())
        if moves.any():
            motion = {"type_error": wrong[moves].mean(), "direction_error": losses.direction, "pivot_error": losses.pivot}
            self._log("validation", int(moves.sum()), **motion)

    def on_validation_epoch_end(self) -> None:
        found = self.trainer.callback_metrics
        names = ("type_error", "rest_error", "direction_error", "pivot_error")
        self.log(MONITOR, sum((found.get(f"validation/{name}", torch.tensor(0.0)) for name in names), torch.tensor(0.0)))

    def _log(self, stage: str, size: int, **values: torch.Tensor) -> None:
        logged: dict[str, Any] = {f"{stage}/{name}": value for name, value in values.items()}
        self.log_dict(logged, on_step=False, on_epoch=True, batch_size=size)
