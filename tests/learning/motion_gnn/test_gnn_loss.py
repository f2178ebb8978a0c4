"""Loss of the motion GNN, compared with calculations by hand."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.learning.motion_gnn.gnn_loss import class_weights, edge_losses
from kinmo.learning.motion_gnn.gnn_network import EdgeOutput


def output(edges: int, classes: int = 10, seed: int = 0) -> EdgeOutput:
    rng = torch.Generator().manual_seed(seed)
    return EdgeOutput(*(torch.randn(edges, n, generator=rng, requires_grad=True) for n in (classes, 3, 3)))


def unit(edges: int) -> torch.Tensor:
    return torch.nn.functional.normalize(torch.randn(edges, 3, generator=torch.Generator().manual_seed(9)), dim=1)


TYPES = torch.tensor([MotionType.R_V_S, MotionType.P_H, MotionType.FIXED, MotionType.NONE, MotionType.PR_V])


def test_the_losses_equal_a_calculation_by_hand() -> None:
    found, d, p = output(5), unit(5), torch.randn(5, 3, generator=torch.Generator().manual_seed(2))
    losses = edge_losses(found, TYPES, d, p)
    probabilities = torch.softmax(found.logits, 1)
    by_hand = -np.mean([np.log(probabilities[i, t].item()) for i, t in enumerate(TYPES)])
    assert losses.type.item() == pytest.approx(by_hand, rel=1e-5)
    directions = [np.linalg.norm((found.directions[i] - d[i]).detach().numpy()) for i in (0, 1, 4)]
    assert losses.direction.item() == pytest.approx(np.mean(directions), rel=1e-5)
    pivots = [np.linalg.norm(np.cross((found.pivots[i] - p[i]).detach().numpy(), d[i].numpy())) for i in (0, 4)]
    assert losses.pivot.item() == pytest.approx(np.mean(pivots), rel=1e-5)
    assert losses.total.item() == pytest.approx(by_hand + np.mean(directions) + np.mean(pivots), rel=1e-5)


def test_the_pivot_loss_ignores_shifts_along_the_axis_and_of_the_object() -> None:
    found, d, p = output(5), unit(5), torch.randn(5, 3)
    slid = edge_losses(found, TYPES, d, p + 7.0 * d).pivot.item()
    shift = torch.tensor([3.0, -2.0, 5.0])
    moved = edge_losses(found._replace(pivots=found.pivots + shift), TYPES, d, p + shift).pivot.item()
    expected = edge_losses(found, TYPES, d, p).pivot.item()
    assert slid == pytest.approx(expected, abs=1e-5)
    assert moved == pytest.approx(expected, abs=1e-5)


def test_the_undirected_loss_ignores_the_sign() -> None:
    found, d = output(5), unit(5)
    losses = [edge_losses(found, TYPES, s * d, d, undirected=True).direction.item() for s in (1, -1)]
    assert losses[0] == pytest.approx(losses[1])


def test_resting_edges_have_no_direction_or_pivot_loss() -> None:
    found = output(2)
    losses = edge_losses(found, torch.tensor([MotionType.FIXED, MotionType.NONE]), unit(2), unit(2))
    assert losses.direction.item() == losses.pivot.item() == 0.0
    losses.total.backward()
    assert found.logits.grad is not None


def test_a_coarse_network_is_trained_on_coarse_classes() -> None:
    found = output(5, classes=5)
    expected = [CoarseType.R, CoarseType.P, CoarseType.FIXED, CoarseType.NONE, CoarseType.PR]
    by_hand = torch.nn.functional.cross_entropy(found.logits, torch.tensor([t.value for t in expected]))
    assert edge_losses(found, TYPES, unit(5), unit(5)).type.item() == pytest.approx(by_hand.item())


def test_balance_gives_rare_classes_more_weight_and_keeps_the_mean_at_one() -> None:
    types = torch.tensor([MotionType.FIXED] * 90 + [MotionType.P_H] * 10)
    weights = class_weights(types, 10, 0.5)
    assert weights is not None
    assert weights[MotionType.P_H] == pytest.approx(3 * weights[MotionType.FIXED].item())
    assert weights[types].mean().item() == pytest.approx(1.0)
    assert class_weights(types, 10, 0.0) is None
