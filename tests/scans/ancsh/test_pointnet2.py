"""PointNet++ in plain torch, compared with brute force."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from kinmo.learning.network_layers import gather_points
from kinmo.scans.ancsh.pointnet2 import (
    MANY_ROWS,
    FeaturePropagation,
    PointLevel,
    PointNetPlusPlus,
    SetAbstraction,
    point_levels,
    product,
)


def clouds(count: int, size: int, seed: int = 0) -> torch.Tensor:
    return torch.rand(count, size, 3, generator=torch.Generator().manual_seed(seed))


def level_of(points: torch.Tensor, centers: int, radius: float = 0.5, neighbours: int = 7) -> PointLevel:
    (level,) = point_levels(points, (centers,), (radius,), (neighbours,))
    return level


def test_centers_of_each_level_are_points_of_the_level_before() -> None:
    points = clouds(3, 60)
    near, far = point_levels(points, (20, 6), (0.3, 0.6), (8, 5))
    for before, level in ((points, near), (near.centers, far)):
        assert (level.centers.unsqueeze(2) == before.unsqueeze(1)).all(-1).any(-1).all()
        assert torch.equal(level.centers[:, 0], points[:, 0])
    assert [level.groups.shape[1:] for level in (near, far)] == [(20, 8), (6, 5)]
    assert [level.centers.shape[1] for level in (near, far)] == [20, 6]


def test_groups_contain_points_within_the_radius_of_their_centers() -> None:
    points = clouds(2, 50)
    level = level_of(points, 7, radius=0.3)
    apart = (gather_points(points, level.groups) - level.centers.unsqueeze(2)).norm(dim=-1)
    assert level.groups.shape == (2, 7, 7)
    assert apart.max() <= 0.3 + 1e-6


def test_interpolation_is_exact_at_centers_and_a_weighted_mean_between_them() -> None:
    points = torch.tensor([[[0.0, 0, 0], [0, 0, 9], [0, 5, 0], [1, 0, 0], [0.25, 0, 0]]])
    level = level_of(points, 4)
    assert level.centers[0].tolist() == points[0, :4].tolist()
    found = level.interpolate(torch.tensor([[[1.0], [1000.0], [100.0], [3.0]]]))
    np.testing.assert_allclose(found[0, :4, 0], [1.0, 1000.0, 100.0, 3.0], rtol=1e-6)
    weights = np.array([0.25, 0.75, np.hypot(0.25, 5.0)]) ** -2
    np.testing.assert_allclose(found[0, 4], weights @ [1, 3, 100] / weights.sum(), rtol=1e-6)


@pytest.mark.parametrize("groups", [1, MANY_ROWS // 8, MANY_ROWS])
def test_products_and_gradients_are_the_same_for_few_and_many_groups(groups: int) -> None:
    torch.manual_seed(0)
    weight, x = torch.randn(6, 7)[:, 2:].requires_grad_(), torch.randn(2, groups, 4, 5, requires_grad=True)
    upstream = torch.randn(2, groups, 4, 6)
    found, expected = product(x, weight), x @ weight.t()
    torch.testing.assert_close(found, expected, rtol=1e-5, atol=1e-5)
    assert found.is_contiguous()
    gradients = [torch.autograd.grad(each, (x, weight), upstream, retain_graph=True) for each in (found, expected)]
    torch.testing.assert_close(*gradients, rtol=1e-4, atol=1e-3)


def test_set_abstraction_joins_relative_coordinates_and_features() -> None:
    torch.manual_seed(0)
    layer = SetAbstraction(5, (8, 6))
    points, features = clouds(2, 40), torch.randn(2, 40, 5)
    level = level_of(points, 9)
    around = gather_points(points, level.groups) - level.centers.unsqueeze(2)
    joined = torch.cat([around, gather_points(features, level.groups)], -1)
    torch.testing.assert_close(layer(points, features, level), layer.layers(joined).amax(2), rtol=1e-4, atol=1e-5)


def test_feature_propagation_joins_interpolated_and_own_features() -> None:
    torch.manual_seed(0)
    layer = FeaturePropagation(5 + 4, (8, 6))
    own, features = torch.randn(2, 40, 4), torch.randn(2, 10, 5)
    level = level_of(clouds(2, 40), 10)
    joined = torch.cat([level.interpolate(features), own], -1)
    torch.testing.assert_close(layer(own, features, level), layer.layers(joined), rtol=1e-4, atol=1e-5)


def test_feature_propagation_joins_global_and_own_features() -> None:
    torch.manual_seed(0)
    layer = FeaturePropagation(5 + 4, (8, 6))
    own, whole = torch.randn(2, 40, 4), torch.randn(2, 1, 5)
    joined = torch.cat([whole.expand(-1, 40, -1), own], -1)
    torch.testing.assert_close(layer(own, whole, None), layer.layers(joined), rtol=1e-4, atol=1e-5)


def test_every_point_has_features_in_the_order_of_the_points() -> None:
    torch.manual_seed(0)
    network = PointNetPlusPlus((32, 8), (0.3, 0.6), (8, 6), 0.25, 0.5).eval()
    points = clouds(2, 80)
    features, whole = network(points)
    assert whole.shape == (2, 1, network.global_features)
    assert features.shape == (2, 80, network.features)
    alone, _ = network(points[1:])
    torch.testing.assert_close(alone, features[1:], rtol=1e-4, atol=1e-5)
