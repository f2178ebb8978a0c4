"""PointNet++ (Qi 2017) in plain torch: points are sampled, grouped and interpolated without compiled extensions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import linear

from kinmo.learning.layers import channel_norm, gather_points, max_over_points

INTERPOLATED = 3
"""Nearest points that features are interpolated from."""


def farthest_points(points: Tensor, count: int) -> Tensor:
    """Indices [B, count] of points of `points` [B, n, 3], from the first on always the one farthest from those before."""
    x, y, z = points.permute(2, 0, 1).contiguous()  # sums over an axis of three are slow
    last = torch.zeros(len(points), 1, dtype=torch.long, device=points.device)
    nearest = torch.full_like(x, torch.inf)
    chosen = [last]
    for _ in range(1, count):
        apart = sum((each - each.gather(1, last)).square() for each in (x, y, z))
        nearest = torch.minimum(nearest, apart)
        last = nearest.argmax(1, keepdim=True)
        chosen.append(last)
    return torch.cat(chosen, 1)


def within_radius(points: Tensor, centers: Tensor, radius: float, count: int) -> Tensor:
    """Indices [B, m, count] of the first points of `points` [B, n, 3] within `radius` of each of `centers` [B, m, 3].

    Where there are fewer the first one is repeated; where there is none it is the last point.
    """
    size = points.shape[1]
    near = torch.cdist(centers, points) <= radius
    order = torch.arange(size, dtype=torch.int32, device=points.device)
    first = torch.where(near, order, size).topk(min(count, size), dim=-1, largest=False).values.long()
    return torch.where(first == size, first[..., :1], first).clamp(max=size - 1)


def interpolated(features: Tensor, places: Tensor, at: Tensor, power: int) -> Tensor:
    """Features [B, n, C] at `at` [B, n, 3], of the nearest of `features` [B, m, C] at `places` [B, m, 3].

    Their weights are 1 / distance ** `power`.
    """
    distances = torch.cdist(at, places)
    nearest, index = distances.topk(min(INTERPOLATED, places.shape[1]), dim=-1, largest=False)
    weights = nearest.clamp(min=1e-6) ** -power
    weights = weights / weights.sum(-1, keepdim=True)
    return torch.zeros_like(distances).scatter_(-1, index, weights) @ features


class SharedLayers(nn.Sequential):
    """Linear layers without a bias, each with a batch norm and a ReLU, over the last axis.

    The first one is linear in what it is given, so that it may go before features are gathered or interpolated for many points:
    it is then asked but once about each of the few that they come from (`first`), and the rest follow (`after_first`).
    """

    def __init__(self, widths: Sequence[int]) -> None:
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [nn.Linear(before, after, bias=False), channel_norm("batch", after), nn.ReLU()]
        super().__init__(*layers)

    def first(self, x: Tensor, start: int = 0) -> Tensor:
        """The first layer's share [..., C'] of those of its channels that `x` [..., C] has, which are those from `start` on."""
        weight: Tensor = self[0].weight  # type: ignore[assignment]
        return linear(x, weight[:, start : start + x.shape[-1]])

    def after_first(self, x: Tensor) -> Tensor:
        """What the other layers make of [..., C']."""
        _, *others = self
        for layer in others:
            x = layer(x)
        return x

    def maxima_after_first(self, x: Tensor) -> Tensor:
        """The same of [B, m, k, C'], its maxima over k; the last ReLU changes no order, so that it can come after them."""
        _, *others, last = self
        for layer in others:
            x = layer(x)
        pooled: Tensor = last(max_over_points(x))
        return pooled


class SetAbstraction(nn.Module):
    """Features of `centers` points from those of their surroundings; of all points together if `centers` is 0."""

    def __init__(self, before: int, widths: Sequence[int], centers: int = 0, radius: float = 0.0, neighbours: int = 0) -> None:
        super().__init__()
        self.centers, self.radius, self.neighbours = centers, radius, neighbours
        self.layers = SharedLayers((3 + before, *widths))

    def forward(self, points: Tensor, features: Tensor | None) -> tuple[Tensor, Tensor]:
        """`points` [B, n, 3], `features` [B, n, C] -> places [B, m, 3] and features [B, m, C']."""
        if not self.centers:
            seen = self.layers.first(points if features is None else torch.cat([points, features], -1))
            return torch.zeros_like(points[:, :1]), self.layers.maxima_after_first(seen.unsqueeze(1))
        chosen = farthest_points(points, min(self.centers, points.shape[1]))
        places = torch.gather(points, 1, chosen.unsqueeze(-1).expand(-1, -1, 3))
        index = within_radius(points, places, self.radius, self.neighbours)
        if features is None:
            seen = self.layers.first(gather_points(points, index) - places.unsqueeze(2))
        else:  # W [x - c, f] = W [x, f] - W [c, 0]
            seen = gather_points(self.layers.first(torch.cat([points, features], -1)), index)
            seen = seen - self.layers.first(places).unsqueeze(2)
        return places, self.layers.maxima_after_first(seen)


class FeaturePropagation(nn.Module):
    """Features of many points from their own and from those of few, interpolated with weights 1 / distance ** `power`."""

    def __init__(self, before: int, widths: Sequence[int], power: int) -> None:
        super().__init__()
        self.power = power
        self.layers = SharedLayers((before, *widths))

    def forward(self, points: Tensor, own: Tensor, places: Tensor, features: Tensor) -> Tensor:
        """`own` [B, n, C] at `points` [B, n, 3], `features` [B, m, D] at `places` [B, m, 3] -> [B, n, C']."""
        spread = interpolated(self.layers.first(features), places, points, self.power)
        return self.layers.after_first(spread + self.layers.first(own, start=features.shape[-1]))


class PointNetPlusPlus(nn.Module):
    """Points [B, n, 3] -> features [B, n, `features`], and [B, 1, `whole_features`] of all, as ANCSH's backbone.

    `width` is the share of the printed widths; `centers`, `radii` and `neighbours` are those of the two levels.
    """

    def __init__(
        self, centers: Sequence[int], radii: Sequence[float], neighbours: int, width: float, power: int, dropout: float
    ) -> None:
        super().__init__()

        def wide(*widths: int) -> tuple[int, ...]:
            return tuple(max(1, round(width * each)) for each in widths)

        near, far, whole = wide(64, 64, 128), wide(128, 128, 256), wide(256, 512, 1024)
        self.near = SetAbstraction(0, near, centers[0], radii[0], neighbours)
        self.far = SetAbstraction(near[-1], far, centers[1], radii[1], neighbours)
        self.whole = SetAbstraction(far[-1], whole)
        to_far, to_near, to_all = wide(256, 256), wide(256, 128), wide(128, 128, 128)
        self.to_far = FeaturePropagation(whole[-1] + far[-1], to_far, power)
        self.to_near = FeaturePropagation(to_far[-1] + near[-1], to_near, power)
        self.to_all = FeaturePropagation(to_near[-1] + 3, to_all, power)
        self.features, self.whole_features = to_all[-1], whole[-1]
        self.last = nn.Sequential(SharedLayers((self.features, self.features)), nn.Dropout(dropout))

    def forward(self, points: Tensor) -> tuple[Tensor, Tensor]:
        near, near_features = self.near(points, None)
        far, far_features = self.far(near, near_features)
        whole, whole_features = self.whole(far, far_features)
        far_features = self.to_far(far, far_features, whole, whole_features)
        near_features = self.to_near(near, near_features, far, far_features)
        return self.last(self.to_all(points, points, near, near_features)), whole_features
