"""PointNet++ in plain torch, against words and brute force."""

from __future__ import annotations

import numpy as np
import torch

from kinmo.learning.ancsh.point_sets import (
    FeaturePropagation,
    PointNetPlusPlus,
    SetAbstraction,
    farthest_points,
    interpolated,
    within_radius,
)
from kinmo.learning.layers import gather_points


def clouds(count: int, size: int, seed: int = 0) -> torch.Tensor:
    return torch.rand(count, size, 3, generator=torch.Generator().manual_seed(seed))


def test_each_sampled_point_is_the_one_farthest_from_those_before() -> None:
    points = clouds(3, 60)
    chosen = farthest_points(points, 10)
    for cloud, indices in zip(points, chosen, strict=True):
        assert indices[0] == 0
        for step in range(1, 10):
            nearest = torch.cdist(cloud, cloud[indices[:step]]).min(1).values
            assert nearest[indices[step]] == nearest.max()


def test_groups_hold_the_first_points_within_the_radius_and_repeat_the_first() -> None:
    points = clouds(2, 50)
    centers = points[:, :7]
    index = within_radius(points, centers, 0.3, 12)
    for cloud, middles, groups in zip(points, centers, index, strict=True):
        for middle, group in zip(middles, groups, strict=True):
            inside = torch.nonzero((cloud - middle).norm(dim=1) <= 0.3).squeeze(1)[:12]
            expected = torch.cat([inside, inside[:1].expand(12 - len(inside))])
            assert torch.equal(group, expected)


def test_interpolation_gives_the_feature_of_a_point_at_that_point_and_means_between() -> None:
    places = torch.tensor([[[0.0, 0, 0], [1, 0, 0], [0, 5, 0], [0, 0, 9]]])
    features = torch.tensor([[[1.0], [3.0], [100.0], [1000.0]]])
    assert interpolated(features, places, places[:, :1], 2).item() == np.float32(1.0)
    at = torch.tensor([[[0.5, 0.0, 0.0]]])
    weights = np.array([0.5, 0.5, np.hypot(0.5, 5.0)]) ** -2
    assert interpolated(features, places, at, 2).item() == np.float32(weights @ [1, 3, 100] / weights.sum())


def test_groups_are_seen_from_their_centres_with_their_features_joined() -> None:
    torch.manual_seed(0)
    layer = SetAbstraction(5, (8, 6), centers=9, radius=0.5, neighbours=7)
    points, features = clouds(2, 40), torch.randn(2, 40, 5)
    places, found = layer(points, features)
    index = within_radius(points, places, 0.5, 7)
    joined = torch.cat([gather_points(points, index) - places.unsqueeze(2), gather_points(features, index)], -1)
    torch.testing.assert_close(found, layer.layers(joined).amax(2), rtol=1e-4, atol=1e-5)


def test_interpolated_features_are_joined_with_a_point_s_own() -> None:
    torch.manual_seed(0)
    layer = FeaturePropagation(5 + 4, (8, 6), power=2)
    points, own, features = clouds(2, 40), torch.randn(2, 40, 4), torch.randn(2, 10, 5)
    places = points[:, :10]
    joined = torch.cat([interpolated(features, places, points, 2), own], -1)
    torch.testing.assert_close(layer(points, own, places, features), layer.layers(joined), rtol=1e-4, atol=1e-5)


def test_every_point_gets_features_and_their_order_follows_that_of_the_points() -> None:
    torch.manual_seed(0)
    network = PointNetPlusPlus((32, 8), (0.3, 0.6), 8, 0.25, 2, 0.5).eval()
    points = clouds(2, 80)
    features, whole = network(points)
    assert whole.shape == (2, 1, network.whole_features)
    assert features.shape == (2, 80, network.features)
    alone, _ = network(points[1:])
    torch.testing.assert_close(alone, features[1:], rtol=1e-4, atol=1e-5)
