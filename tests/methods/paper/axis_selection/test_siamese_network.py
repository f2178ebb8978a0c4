"""The Siamese network of the axis selection, and its weights (paper, section 3.3)."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch

from kinmo.config import load_config
from kinmo.core.errors import InputError
from kinmo.learning.weights import save_weights
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.axis_selection.siamese_network import AxisSelectionNetwork

PAPER, SMALL = (load_config(name).axis for name in ("paper", "small"))


def test_the_configuration_paper_has_the_releases_parameters() -> None:
    """Count the release's parameters per layer: layers before a norm have no bias, norms have two parameters per channel."""
    encoder = 8 * 64 + 128 * 64 + 128 * 128 + 256 * 128 + 2 * (64 + 64 + 128 + 128)
    head = 512 * 256 + 256 * 128 + 2 * (256 + 128) + 128 + 1
    assert sum(p.numel() for p in AxisSelectionNetwork(PAPER).parameters()) == encoder + head


def test_both_clouds_pass_the_same_encoder() -> None:
    torch.manual_seed(0)
    network = AxisSelectionNetwork(SMALL).eval()
    clouds = torch.randn(3, 2, 64, 4)
    logits = network(*clouds)
    features = [network.encoder(cloud) for cloud in clouds]
    expected = torch.cat([network.compare(features[0], features[i]) for i in (1, 2)])
    torch.testing.assert_close(logits, expected, atol=1e-5, rtol=1e-5)


def test_the_order_of_points_does_not_matter() -> None:
    torch.manual_seed(0)
    network = AxisSelectionNetwork(SMALL).eval()
    one, other = torch.randn(2, 2, 64, 4)
    order = torch.randperm(64)
    torch.testing.assert_close(network(one, other), network(one[:, order], other), atol=1e-5, rtol=1e-5)


def test_weights_of_another_network_are_refused(tmp_path: Path) -> None:
    save_weights(tmp_path / "weights.safetensors", torch.nn.Linear(1, 1), "motion_gnn", {})
    with pytest.raises(InputError, match="kind: expected 'axis_selection', got 'motion_gnn'"):
        AxisSelector.load(tmp_path / "weights.safetensors", "cpu")
