"""Loss of the motion GNN: L = L_cls + L_dir + L_pos (paper, section 3.2)."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy

from kinmo.core.joint import JointKind
from kinmo.core.motion_types import MotionType
from kinmo.learning.motion_gnn.gnn_network import EdgeOutput

_COARSE_OF_FINE = torch.tensor([t.coarse.value for t in MotionType])
_IS_PRISMATIC = torch.tensor([t.kind is JointKind.PRISMATIC for t in MotionType])


class EdgeLosses(NamedTuple):
    """The three terms of the loss, each a scalar; zero where no edge contributes."""

    type: Tensor
    direction: Tensor
    pivot: Tensor

    @property
    def total(self) -> Tensor:
        """Sum of the terms, with unit weights."""
        return self.type + self.direction + self.pivot


def edge_losses(
    output: EdgeOutput,
    types: Tensor,
    directions: Tensor,
    pivots: Tensor,
    class_weights: Tensor | None = None,
    undirected: bool = False,
) -> EdgeLosses:
    """Losses over E edges (paper, section 3.2).

    L_cls is the mean cross entropy. L_dir is ||d - d^||, not squared, over motion edges. L_pos is ||(p - p^) x d^|| / ||d^||,
    the mean over edges of rotating types (R and PR).

    Args:
        output: Predictions of the network.
        types: True fine types [E], for fine and coarse networks alike.
        directions: True unit directions [E, 3].
        pivots: True pivots [E, 3].
        class_weights: Weight of each class [C] in L_cls; None for equal weights.
        undirected: Whether L_dir is the distance to the nearer of d^ and -d^.
    """
    zero = output.logits.sum() * 0.0
    targets = classes_of(types, output.logits.shape[1])
    moves = types < MotionType.FIXED
    rotates = moves & ~_IS_PRISMATIC.to(types.device)[types]
    type_loss = cross_entropy(output.logits, targets, class_weights) if len(types) else zero
    direction_term = pivot_term = zero
    if moves.any():
        predicted, true = output.directions[moves], directions[moves]
        norms = torch.linalg.vector_norm(predicted - true, dim=1)
        if undirected:
            norms = torch.minimum(norms, torch.linalg.vector_norm(predicted + true, dim=1))
        direction_term = norms.mean()
    if rotates.any():
        across = torch.linalg.cross(output.pivots[rotates] - pivots[rotates], directions[rotates])
        lengths = torch.linalg.vector_norm(directions[rotates], dim=1)
        pivot_term = (torch.linalg.vector_norm(across, dim=1) / lengths).mean()
    return EdgeLosses(type_loss, direction_term, pivot_term)


def classes_of(types: Tensor, classes: int) -> Tensor:
    """Classes [E] of fine motion types [E] for a network with 10 fine or 5 coarse classes."""
    return types if classes == len(MotionType) else _COARSE_OF_FINE.to(types.device)[types]


def class_weights(types: Tensor, classes: int, balance: float) -> Tensor | None:
    """Weights of the classes in L_cls: (share of the training edges) ** -balance, with a mean of one over the training edges.

    They are weights [C] for C classes and the fine types of all training edges [E]; None (all one) without a balance.
    """
    if not balance:
        return None
    targets = classes_of(types, classes)
    share = torch.bincount(targets, minlength=classes) / max(len(targets), 1)
    scale = share.clamp(min=1 / max(len(targets), 1)).pow(-balance)
    return scale / (share * scale).sum()
