"""Building blocks of networks: neighbours, gather, scatter, maxima and edge convolutions."""

from __future__ import annotations

import pytest
import torch

from kinmo.learning.network_layers import (
    EdgeConv,
    gather_points,
    max_over_points,
    nearest_neighbours,
    neighbour_max,
    scatter_max,
    scatter_mean,
)


def test_neighbours_agree_with_the_distance_matrix() -> None:
    points = torch.randn(3, 40, 3, generator=torch.Generator().manual_seed(0))
    found = nearest_neighbours(points, 7).sort(-1).values
    expected = torch.cdist(points, points).topk(7, largest=False).indices.sort(-1).values
    assert torch.equal(found, expected)


def test_few_points_have_few_neighbours() -> None:
    assert nearest_neighbours(torch.randn(1, 4, 3), 20).shape == (1, 4, 4)


def test_gathered_points_have_the_given_indices() -> None:
    features = torch.randn(2, 5, 3)
    index = torch.randint(5, (2, 5, 4))
    expected = torch.stack([features[b][index[b]] for b in range(2)])
    assert torch.equal(gather_points(features, index), expected)


@pytest.mark.parametrize("kind", [torch.float32, torch.float64, torch.bfloat16])
def test_maxima_over_neighbours_send_the_gradient_to_the_first_of_equal_values(kind: torch.dtype) -> None:
    features = torch.randint(3, (2, 20, 5)).to(kind).requires_grad_()
    index = nearest_neighbours(torch.randn(2, 20, 3), 6)
    weights = torch.randint(-9, 9, (2, 20, 5)).to(kind)
    found = neighbour_max(features, index)
    (slopes,) = torch.autograd.grad((found * weights).sum(), features)
    gathered = gather_points(features, index)
    assert torch.equal(found, gathered.amax(2))
    first = index.gather(2, gathered.argmax(2))
    assert torch.equal(slopes, torch.zeros_like(features).scatter_add(1, first, weights))


@pytest.mark.parametrize("norm", ["none", "batch", "group"])
def test_an_edge_convolution_is_a_maximum_over_neighbours_of_a_linear_map(norm: str) -> None:
    torch.manual_seed(0)
    layer = EdgeConv(3, 16, norm, factored=False).eval()
    points = torch.randn(2, 12, 3)
    index = nearest_neighbours(points, 4)
    near = gather_points(points, index)
    pairs = layer.neighbour(near - points.unsqueeze(2)) + layer.center(points).unsqueeze(2)
    expected = torch.nn.functional.leaky_relu(layer.norm(pairs), 0.2).amax(2)
    torch.testing.assert_close(layer(points, index), expected, atol=1e-5, rtol=1e-5)


def test_the_factored_edge_convolution_is_the_same_map_with_other_matrices() -> None:
    torch.manual_seed(0)
    plain, factored = EdgeConv(3, 16, "none", False), EdgeConv(3, 16, "none", True)
    factored.neighbour.weight.data = plain.neighbour.weight.data
    factored.center.weight.data = plain.center.weight.data - plain.neighbour.weight.data
    points = torch.randn(2, 12, 3)
    index = nearest_neighbours(points, 4)
    torch.testing.assert_close(factored(points, index), plain(points, index), atol=1e-5, rtol=1e-5)


def test_scatters_agree_with_loops() -> None:
    values, index = torch.randn(9, 2), torch.tensor([0, 2, 2, 1, 0, 0, 2, 1, 1])
    mean, count = scatter_mean(values, index, 4)
    for slot in range(3):
        torch.testing.assert_close(mean[slot], values[index == slot].mean(0))
        torch.testing.assert_close(scatter_max(values, index, 3)[slot], values[index == slot].amax(0))
    assert count.tolist() == [3, 3, 3, 0]
    assert mean[3].tolist() == [0, 0]


def test_maxima_over_points_send_the_gradient_to_the_first_of_equal_values() -> None:
    features = torch.randint(4, (3, 5, 6, 7), generator=torch.Generator().manual_seed(0)).float().requires_grad_()
    found = max_over_points(features)
    weights = torch.randn(3, 5, 7)
    (slopes,) = torch.autograd.grad((found * weights).sum(), features)
    first = features.argmax(2, keepdim=True)
    assert torch.equal(found, features.amax(2))
    assert torch.equal(slopes, torch.zeros_like(features).scatter(2, first, weights.unsqueeze(2)))
