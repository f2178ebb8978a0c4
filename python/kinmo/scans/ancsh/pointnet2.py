"""PointNet++ (Qi et al. 2017b) in plain torch, as the backbone of ANCSH (Li et al. 2020, section 4).

Groups of points depend on coordinates alone, so the Rust core finds them before the network runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn.functional import conv2d, linear

from kinmo import _core
from kinmo.learning.network_layers import channel_norm, gather_points, max_over_points

MIN_DISTANCE = 1e-6
"""Least distance in the weights of an interpolation."""
MANY_ROWS = 8192
"""Number of rows of few features above which a CPU's convolutions are faster than its matrix products."""
HAS_ONEDNN: bool = torch.backends.mkldnn.is_available()  # type: ignore[no-untyped-call]


@dataclass(frozen=True, eq=False)
class PointLevel:
    """Groups of the n points in each of B clouds around m centers.

    Attributes:
        centers: Coordinates of the centers [B, m, 3].
        groups: Indices of the points in each group [B, m, k].
        nearest: Indices of the centers nearest to each point [B, n, i], from which its features are interpolated.
        weights: Weights of these centers [B, n, i]; they add up to 1.
    """

    centers: Tensor
    groups: Tensor
    nearest: Tensor
    weights: Tensor

    def interpolate(self, features: Tensor) -> Tensor:
        """Features of the points [B, n, C], interpolated from those of the centers [B, m, C]."""
        shape = (*self.nearest.shape[:2], features.shape[1])
        spread = torch.zeros(shape, dtype=features.dtype, device=features.device)
        return spread.scatter_(-1, self.nearest, self.weights.to(features.dtype)) @ features


def point_levels(
    points: Tensor, centers: Sequence[int], radii: Sequence[float], neighbours: Sequence[int]
) -> tuple[PointLevel, ...]:
    """Groups of points on several levels; the centers of one level are the points of the next.

    All levels are found on the CPU at once. A GPU would otherwise have to wait for each of them. Each level has a number of
    centers m, a radius of the groups, and a number of points k in a group.
    """
    current, levels = points.detach().float().cpu(), []
    for count, radius, size in zip(centers, radii, neighbours, strict=True):
        chosen, *indices, distances = map(torch.from_numpy, _core.group_points(current.numpy(), count, radius, size))
        current = current.gather(1, chosen.unsqueeze(-1).expand(-1, -1, 3))
        weights = distances.clamp(min=MIN_DISTANCE) ** -2
        weights = weights / weights.sum(-1, keepdim=True)
        levels.append(PointLevel(*(each.to(points.device) for each in (current, *indices, weights))))
    return tuple(levels)


def product(x: Tensor, weight: Tensor) -> Tensor:
    """Product of features [..., C] with the transpose of a weight matrix [C', C].

    On a CPU, many groups [B, m, k, C] are multiplied by a convolution: for many rows of few features oneDNN's convolutions are
    faster than its matrix products.
    """
    is_many = x.dim() == 4 and x.shape[:3].numel() > MANY_ROWS
    if is_many and x.is_cpu and x.dtype == torch.float32 and HAS_ONEDNN:
        return conv2d(x.permute(0, 3, 1, 2), weight[:, :, None, None]).permute(0, 2, 3, 1)
    return linear(x, weight)


class SharedLinear(nn.Linear):
    """Linear layer without a bias over the last axis."""

    def forward(self, x: Tensor) -> Tensor:
        return product(x, self.weight)


class SharedLayers(nn.Sequential):
    """Linear layers without a bias over the last axis, each with a batch norm and a ReLU.

    The first layer is linear in its input. It can therefore run before features are gathered or interpolated (`first`), on few
    points instead of many; the other layers follow (`after_first`). `widths` are the channels of the input and of each layer.
    """

    def __init__(self, widths: Sequence[int]) -> None:
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [SharedLinear(before, after, bias=False), channel_norm("batch", after), nn.ReLU()]
        super().__init__(*layers)

    def first(self, x: Tensor, start: int = 0) -> Tensor:
        """Share of the first layer's output [..., C'] that comes from its input channels `start` to `start` + C - 1 alone."""
        weight: Tensor = self[0].weight  # type: ignore[assignment]
        return product(x, weight[:, start : start + x.shape[-1]])

    def after_first(self, x: Tensor) -> Tensor:
        """Output of all layers from the output of the first linear layer [..., C']."""
        _, *others = self
        for layer in others:
            x = layer(x)
        return x

    def maxima_after_first(self, x: Tensor) -> Tensor:
        """Maxima over k of `after_first` of [B, m, k, C']. The last ReLU keeps the order, so it runs after the maximum."""
        _, *others, last = self
        for layer in others:
            x = layer(x)
        pooled: Tensor = last(max_over_points(x))
        return pooled


class SetAbstraction(nn.Module):
    """Features of groups of points, from the points' coordinates relative to the center and from their features.

    The features have `before` channels C, 0 for none; the last of the layers' `widths` is C'.
    """

    def __init__(self, before: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.layers = SharedLayers((3 + before, *widths))

    def forward(self, points: Tensor, features: Tensor | None, level: PointLevel | None) -> Tensor:
        """Features [B, m, C'] of the groups of a level, or [B, 1, C'] of all points together if there is no level.

        Points are [B, n, 3], and their features [B, n, C].
        """
        if level is None:
            inputs = self.layers.first(points if features is None else torch.cat([points, features], -1))
            return self.layers.maxima_after_first(inputs.unsqueeze(1))
        if features is None:
            inputs = self.layers.first(gather_points(points, level.groups) - level.centers.unsqueeze(2))
        else:  # W [x - c, f] = W [x, f] + W [-c, 0]; a difference would add a negation to the backward pass
            inputs = gather_points(self.layers.first(torch.cat([points, features], -1)), level.groups)
            inputs = inputs + self.layers.first(-level.centers).unsqueeze(2)
        return self.layers.maxima_after_first(inputs)


class FeaturePropagation(nn.Module):
    """Features of many points, from their own features and from those of the centers of a level.

    The `before` input channels are those of the centers and those of the points; the last of the layers' `widths` is C'.
    """

    def __init__(self, before: int, widths: Sequence[int]) -> None:
        super().__init__()
        self.layers = SharedLayers((before, *widths))

    def forward(self, own: Tensor, features: Tensor, level: PointLevel | None) -> Tensor:
        """Features of the points [B, n, C'], from their own [B, n, C] and those of the centers [B, m, D].

        Without a level, `features` [B, 1, D] are of all points together.
        """
        spread = self.layers.first(features)
        spread = spread if level is None else level.interpolate(spread)
        return self.layers.after_first(spread + self.layers.first(own, start=features.shape[-1]))


class PointNetPlusPlus(nn.Module):
    """PointNet++ with two levels of groups and one global feature, the backbone of ANCSH.

    The arguments are those of `AncshConfig`. The attributes `features` and `global_features` are the widths of the results.
    """

    def __init__(
        self, centers: Sequence[int], radii: Sequence[float], neighbours: Sequence[int], width: float, dropout: float
    ) -> None:
        super().__init__()

        def wide(*widths: int) -> tuple[int, ...]:
            return tuple(max(1, round(width * each)) for each in widths)

        self.grouping = tuple(centers), tuple(radii), tuple(neighbours)
        near, far, whole = wide(64, 64, 128), wide(128, 128, 256), wide(256, 512, 1024)
        self.near = SetAbstraction(0, near)
        self.far = SetAbstraction(near[-1], far)
        self.whole = SetAbstraction(far[-1], whole)
        to_far, to_near, to_all = wide(256, 256), wide(256, 128), wide(128, 128, 128)
        self.to_far = FeaturePropagation(whole[-1] + far[-1], to_far)
        self.to_near = FeaturePropagation(to_far[-1] + near[-1], to_near)
        self.to_all = FeaturePropagation(to_near[-1] + 3, to_all)
        self.features, self.global_features = to_all[-1], whole[-1]
        self.last = nn.Sequential(SharedLayers((self.features, self.features)), nn.Dropout(dropout))

    def forward(self, points: Tensor) -> tuple[Tensor, Tensor]:
        """Features of every point [B, n, features] and of each cloud [B, 1, global_features], from points [B, n, 3]."""
        near, far = point_levels(points, *self.grouping)
        near_features = self.near(points, None, near)
        far_features = self.far(near.centers, near_features, far)
        global_features = self.whole(far.centers, far_features, None)
        far_features = self.to_far(far_features, global_features, None)
        near_features = self.to_near(near_features, far_features, far)
        return self.last(self.to_all(points, near_features, near)), global_features
