"""PointNet++ (Qi 2017) in plain torch: who is in which group is found by the core, as it depends on places alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import conv2d, linear

from kinmo import _core
from kinmo.learning.network_layers import channel_norm, gather_points, max_over_points

LEAST_DISTANCE = 1e-6
"""From which on distances tell weights."""

MANY_ROWS = 8192
"""Of few features, from which on a CPU's convolutions beat its products."""

HAS_ONEDNN: bool = torch.backends.mkldnn.is_available()  # type: ignore[no-untyped-call]


@dataclass(frozen=True, eq=False)
class Level:
    """Groups of the n points of B clouds, about m of them.

    `places` [B, m, 3] are those of the centers, `groups` [B, m, k] the points in each group. Of the centers, the `nearest`
    [B, n, i] are those that features of every point are interpolated from, with `weights` [B, n, i] that add up to 1.
    """

    places: Tensor
    groups: Tensor
    nearest: Tensor
    weights: Tensor

    def interpolated(self, features: Tensor) -> Tensor:
        """Features [B, n, C] of the points, from those [B, m, C] of the centers."""
        shape = (*self.nearest.shape[:2], features.shape[1])
        spread = torch.zeros(shape, dtype=features.dtype, device=features.device)
        return spread.scatter_(-1, self.nearest, self.weights.to(features.dtype)) @ features


def levels_of(
    points: Tensor, centers: Sequence[int], radii: Sequence[float], neighbours: Sequence[int], power: int
) -> tuple[Level, ...]:
    """Levels of `points` [B, n, 3], each of the centers of the one before, so many, with these radii and with groups of so many
    `neighbours`.

    Weights are 1 / distance ** `power`. All is found before a network runs, as a GPU would have to wait for it else.
    """
    here, found = points.detach().float().cpu(), []
    for count, radius, size in zip(centers, radii, neighbours, strict=True):
        chosen, *indices, distances = map(torch.from_numpy, _core.group_points(here.numpy(), count, radius, size))
        here = here.gather(1, chosen.unsqueeze(-1).expand(-1, -1, 3))
        weights = distances.clamp(min=LEAST_DISTANCE) ** -power
        weights = weights / weights.sum(-1, keepdim=True)
        found.append(Level(*(each.to(points.device) for each in (here, *indices, weights))))
    return tuple(found)


def product(x: Tensor, weight: Tensor) -> Tensor:
    """`x` [..., C] times the transpose of `weight` [C', C].

    Of many groups [B, m, k, C] on a CPU it is asked for as a convolution: for many rows of few features oneDNN's kernels are
    faster than those for products.
    """
    is_many = x.dim() == 4 and x.shape[:3].numel() > MANY_ROWS
    if is_many and x.is_cpu and x.dtype == torch.float32 and HAS_ONEDNN:
        return conv2d(x.permute(0, 3, 1, 2), weight[:, :, None, None]).permute(0, 2, 3, 1)
    return linear(x, weight)


class SharedLinear(nn.Linear):
    """A linear layer without a bias over the last axis."""

    def __init__(self, before: int, after: int) -> None:
        super().__init__(before, after, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        return product(x, self.weight)


class SharedLayers(nn.Sequential):
    """Linear layers without a bias, each with a batch norm and a ReLU, over the last axis.

    The first one is linear in what it is given, so that it may go before features are gathered or interpolated for many points:
    it is then asked but once about each of the few that they come from (`first`), and the rest follow (`after_first`).
    """

    def __init__(self, widths: Sequence[int]) -> None:
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [SharedLinear(before, after), channel_norm("batch", after), nn.ReLU()]
        super().__init__(*layers)

    def first(self, x: Tensor, start: int = 0) -> Tensor:
        """The first layer's share [..., C'] of those of its channels that `x` [..., C] has, which are those from `start` on."""
        weight: Tensor = self[0].weight  # type: ignore[assignment]
        return product(x, weight[:, start : start + x.shape[-1]])

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
    """Features of groups of points, from those of the points and where these lie."""

    def __init__(self, before: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.layers = SharedLayers((3 + before, *widths))

    def forward(self, points: Tensor, features: Tensor | None, level: Level | None) -> Tensor:
        """`points` [B, n, 3], `features` [B, n, C] -> [B, m, C'], of the groups of a level, or else of all points together."""
        if level is None:
            seen = self.layers.first(points if features is None else torch.cat([points, features], -1))
            return self.layers.maxima_after_first(seen.unsqueeze(1))
        if features is None:
            seen = self.layers.first(gather_points(points, level.groups) - level.places.unsqueeze(2))
        else:  # W [x - c, f] = W [x, f] + W [-c, 0], a sum rather than a difference, which would go backward through a negation
            seen = gather_points(self.layers.first(torch.cat([points, features], -1)), level.groups)
            seen = seen + self.layers.first(-level.places).unsqueeze(2)
        return self.layers.maxima_after_first(seen)


class FeaturePropagation(nn.Module):
    """Features of many points, from their own and from those of the centers of a level, or of all points together."""

    def __init__(self, before: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.layers = SharedLayers((before, *widths))

    def forward(self, own: Tensor, features: Tensor, level: Level | None) -> Tensor:
        """`own` [B, n, C], `features` [B, m, D] of the centers, or [B, 1, D] without a level -> [B, n, C']."""
        spread = self.layers.first(features)
        spread = spread if level is None else level.interpolated(spread)
        return self.layers.after_first(spread + self.layers.first(own, start=features.shape[-1]))


class PointNetPlusPlus(nn.Module):
    """Points [B, n, 3] -> features [B, n, `features`], and [B, 1, `whole_features`] of all, as ANCSH's backbone.

    `width` is the share of the printed widths; `centers`, `radii` and `neighbours` are those of the two levels.
    """

    def __init__(
        self,
        centers: Sequence[int],
        radii: Sequence[float],
        neighbours: Sequence[int],
        width: float,
        power: int,
        dropout: float,
    ) -> None:
        super().__init__()

        def wide(*widths: int) -> tuple[int, ...]:
            return tuple(max(1, round(width * each)) for each in widths)

        self.grouping = tuple(centers), tuple(radii), tuple(neighbours), power
        near, far, whole = wide(64, 64, 128), wide(128, 128, 256), wide(256, 512, 1024)
        self.near = SetAbstraction(0, near)
        self.far = SetAbstraction(near[-1], far)
        self.whole = SetAbstraction(far[-1], whole)
        to_far, to_near, to_all = wide(256, 256), wide(256, 128), wide(128, 128, 128)
        self.to_far = FeaturePropagation(whole[-1] + far[-1], to_far)
        self.to_near = FeaturePropagation(to_far[-1] + near[-1], to_near)
        self.to_all = FeaturePropagation(to_near[-1] + 3, to_all)
        self.features, self.whole_features = to_all[-1], whole[-1]
        self.last = nn.Sequential(SharedLayers((self.features, self.features)), nn.Dropout(dropout))

    def forward(self, points: Tensor) -> tuple[Tensor, Tensor]:
        near, far = levels_of(points, *self.grouping)
        near_features = self.near(points, None, near)
        far_features = self.far(near.places, near_features, far)
        whole_features = self.whole(far.places, far_features, None)
        far_features = self.to_far(far_features, whole_features, None)
        near_features = self.to_near(near_features, far_features, far)
        return self.last(self.to_all(points, near_features, near)), whole_features
