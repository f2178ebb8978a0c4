"""L = L_cls + L_dir + L_pos (paper, section 3.2)."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy

from kinmo.core.errors import InputError
from kinmo.core.joint import JointKind, MotionType
from kinmo.learning.layers import scatter_mean
from kinmo.learning.motion_gnn.gnn_network import EdgeOutput

COARSE_OF_FINE = torch.tensor([t.coarse.value for t in MotionType])
"""The coarse class of each fine one."""

_SLIDES_ONLY = torch.tensor([t.kind is JointKind.PRISMATIC for t in MotionType])


class EdgeLosses(NamedTuple):
    """Each a scalar; zero where no edge has what it is of."""

    type: Tensor
    direction: Tensor
    pivot: Tensor

    @property
    def total(self) -> Tensor:
        return self.type + self.direction + self.pivot


def edge_losses(
    output: EdgeOutput,
    types: Tensor,
    directions: Tensor,
    pivots: Tensor,
    class_weights: Tensor | None = None,
    direction_loss: str = "mean",
) -> EdgeLosses:
    """The three losses over E edges.

    `types` [E] are fine types whatever the network's classes, `directions` [E, 3] unit vectors, `pivots` [E, 3]. L_cls is the
    mean cross entropy. L_dir = ||d - d^||, un-squared, over motion edges: their mean, or as `frobenius` one norm over all, or
    `undirected` to the nearer of d^ and -d^. L_pos = ||(p - p^) x d^|| / ||d^||, the mean over R and PR edges.
    """
    zero = output.logits.sum() * 0.0
    targets = types if output.logits.shape[1] == len(MotionType) else COARSE_OF_FINE.to(types.device)[types]
    moves = types < MotionType.FIXED
    turns = moves & ~_SLIDES_ONLY.to(types.device)[types]
    type_loss = cross_entropy(output.logits, targets, class_weights) if len(types) else zero
    direction_term = pivot_term = zero
    if moves.any():
        found, true = output.directions[moves], directions[moves]
        norms = torch.linalg.vector_norm(found - true, dim=1)
        if direction_loss == "undirected":
            norms = torch.minimum(norms, torch.linalg.vector_norm(found + true, dim=1))
        direction_term = torch.linalg.vector_norm(norms) if direction_loss == "frobenius" else norms.mean()
    if turns.any():
        across = torch.linalg.cross(output.pivots[turns] - pivots[turns], directions[turns])
        lengths = torch.linalg.vector_norm(directions[turns], dim=1)
        pivot_term = (torch.linalg.vector_norm(across, dim=1) / lengths).mean()
    return EdgeLosses(type_loss, direction_term, pivot_term)


def class_weights(types: Tensor, classes: int, given: tuple[float, ...], balance: float) -> Tensor | None:
    """Weights [classes]: `given` (ones if empty) times the class's share of `types` ** -balance; None if all are one.

    Those `given` are of the ten fine types; of five classes each has the mean of its own. Raises InputError for another number.
    """
    if not given and not balance:
        return None
    if len(given) not in (0, len(MotionType)):
        raise InputError("gnn.class_weights", f"expected {len(MotionType)} numbers, one a motion type, got {len(given)}")
    weights = torch.tensor(given or (1.0,) * len(MotionType))
    if classes != len(MotionType):
        weights, _ = scatter_mean(weights.unsqueeze(1), COARSE_OF_FINE, classes)
        weights = weights.squeeze(1)
    if balance:
        targets = types if classes == len(MotionType) else COARSE_OF_FINE[types]
        share = torch.bincount(targets, minlength=classes) / max(len(targets), 1)
        scale = share.clamp(min=1 / max(len(targets), 1)).pow(-balance)
        weights = weights * scale / (share * scale).sum()
    return weights
