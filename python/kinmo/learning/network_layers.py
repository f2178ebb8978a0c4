"""Building blocks of the networks in plain torch: MLPs, scatter and gather operations, DGCNN and PointNet encoders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from kinmo import _core
from kinmo.config import PointEncoderConfig

DGCNN_SLOPE = 0.2
"""Negative slope of the LeakyReLU in DGCNN."""


def mlp(widths: Sequence[int], activation: type[nn.Module], last: bool = True) -> nn.Sequential:
    """Multi-layer perceptron from [*, widths[0]] to [*, widths[-1]]; `last` adds the activation after the last layer, too."""
    layers: list[nn.Module] = []
    for index, (before, after) in enumerate(pairwise(widths)):
        layers.append(nn.Linear(before, after))
        if last or index < len(widths) - 2:
            layers.append(activation())
    return nn.Sequential(*layers)


def scatter_mean(values: Tensor, index: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """Mean [size, C] of the rows of `values` [M, C] that share an index, and the number of these rows [size].

    The mean is zero for an index without rows.
    """
    total = values.new_zeros(size, values.shape[1]).index_add_(0, index, values)
    count = values.new_zeros(size).index_add_(0, index, values.new_ones(len(index)))
    return total / count.clamp(min=1).unsqueeze(1), count


def scatter_max(values: Tensor, index: Tensor, size: int) -> Tensor:
    """Maximum [size, C] of the rows of `values` [M, C] that share an index; every index must have a row."""
    target = values.new_zeros(size, values.shape[1])
    return target.scatter_reduce(0, index.unsqueeze(1).expand_as(values), values, "amax", include_self=False)


def nearest_neighbours(points: Tensor, count: int) -> Tensor:
    """Indices [B, n, k] of the k = min(count, n) nearest points of each point of clouds [B, n, C], in no particular order.

    The point itself is among them.
    """
    if points.is_cpu and points.dtype == torch.float32 and points.shape[2] == 3:
        return torch.from_numpy(_core.nearest_neighbours(points.detach().numpy(), count))
    squared = points.square().sum(-1)
    affinity = torch.baddbmm(squared.neg().unsqueeze(1), points, points.transpose(1, 2), beta=1.0, alpha=2.0)
    return affinity.topk(min(count, points.shape[1]), dim=-1, sorted=False).indices


def gather_points(features: Tensor, index: Tensor) -> Tensor:
    """Features [B, m, k, C] of the points with the indices `index` [B, m, k], taken from `features` [B, n, C]."""
    clouds, size, width = features.shape
    rows = index + torch.arange(clouds, device=index.device).view(-1, 1, 1) * size  # rows of all clouds together
    return features.reshape(-1, width).index_select(0, rows.flatten()).view(*index.shape, width)


def max_over_points(features: Tensor) -> Tensor:
    """Maxima [B, m, C] of `features` [B, m, k, C] over k. Among equal values the first receives the gradient."""
    with torch.no_grad():  # a pooling layer finds the maxima fastest, but its backward pass is slow for channels-last data
        _, places = nn.functional.max_pool2d(features.permute(0, 3, 1, 2), (1, features.shape[2]), return_indices=True)
    return features.flatten(1, 2).gather(1, places.squeeze(3).transpose(1, 2))


def neighbour_max(features: Tensor, index: Tensor) -> Tensor:
    """Maxima [B, m, C] of `features` [B, n, C] over neighbours with the indices `index` [B, m, k], channel by channel.

    Among equal values the first neighbour receives the gradient.
    """
    if features.is_cpu and features.dtype == torch.float32:
        # the core returns the index of each maximum, so that no tensor of the size of all pairs is made, forward or backward
        return features.gather(1, torch.from_numpy(_core.neighbour_argmax(features.detach().numpy(), index.numpy())))
    return max_over_points(gather_points(features, index))


def channel_norm(kind: str, width: int) -> nn.Module:
    """Normalisation of tensors [..., width]: "batch" norm, "group" norm with about 8 channels a group, or "none"."""
    return nn.Identity() if kind == "none" else _ChannelsLastNorm(kind, width)


class _ChannelsLastNorm(nn.Module):
    """Batch or group norm over the last axis."""

    def __init__(self, kind: str, width: int) -> None:
        super().__init__()
        self.norm = nn.BatchNorm1d(width) if kind == "batch" else nn.GroupNorm(math.gcd(width, max(width // 8, 1)), width)

    def forward(self, x: Tensor) -> Tensor:
        if isinstance(self.norm, nn.BatchNorm1d):
            return self.norm(x.reshape(-1, x.shape[-1])).view_as(x)  # type: ignore[no-any-return]
        if x.dim() == 2:
            return self.norm(x)  # type: ignore[no-any-return]
        return self.norm(x.flatten(1, -2).transpose(1, 2)).transpose(1, 2).reshape(x.shape)  # type: ignore[no-any-return]


class EdgeConv(nn.Module):
    """Edge convolution: max over neighbours j of LeakyReLU(norm(W [x_j - x_i, x_i])) (DGCNN, Wang et al. 2019, section 3.1).

    The factored form writes W [x_j - x_i, x_i] as A x_j + C x_i and moves C x_i and the norm out of the maximum. It has the
    same number of parameters, and no tensor of the size of all pairs.
    """

    def __init__(self, before: int, after: int, norm: str, factored: bool) -> None:
        super().__init__()
        self.neighbour = nn.Linear(before, after, bias=False)
        self.center = nn.Linear(before, after, bias=False)
        self.norm = channel_norm(norm, after)
        self.factored = factored

    def forward(self, features: Tensor, index: Tensor) -> Tensor:
        """Features [B, n, C'] from `features` [B, n, C] and the neighbours' indices `index` [B, n, k]."""
        near, center = self.neighbour(features), self.center(features)
        if self.factored:
            pooled = neighbour_max(near, index) + center
            return nn.functional.leaky_relu(self.norm(pooled), DGCNN_SLOPE)
        pairs = gather_points(near, index) + (center - near).unsqueeze(2)
        return nn.functional.leaky_relu(self.norm(pairs), DGCNN_SLOPE).amax(2)


class Dgcnn(nn.Module):
    """DGCNN encoder of point clouds (Wang et al. 2019), from points [B, n, C] to features [B, F].

    The first three channels of a point are its coordinates. Every layer finds neighbours anew among the features of the layer
    before, unless `PointEncoderConfig.static` is set. `features` is the width F of the result.
    """

    def __init__(self, config: PointEncoderConfig, channels: int = 3) -> None:
        super().__init__()
        widths = (channels, *config.widths)
        self.neighbours, self.static = config.neighbours, config.static
        self.convolutions = nn.ModuleList(
            EdgeConv(before, after, config.norm, config.factored) for before, after in pairwise(widths)
        )
        self.embedding = nn.Linear(sum(config.widths), config.embedding, bias=False)
        self.embedding_norm = channel_norm(config.norm, config.embedding)
        self.features = config.features or 2 * config.embedding
        layers: list[nn.Module] = []
        width = 2 * config.embedding
        for after in config.head:
            layers += [nn.Linear(width, after, bias=False), channel_norm(config.norm, after), nn.LeakyReLU(DGCNN_SLOPE)]
            layers += [nn.Dropout(config.dropout)] if config.dropout else []
            width = after
        if config.features:
            layers.append(nn.Linear(width, config.features))
        self.head = nn.Sequential(*layers)

    def forward(self, points: Tensor) -> Tensor:
        index = nearest_neighbours(points[..., :3], self.neighbours)
        features, levels = points, []
        for depth, convolution in enumerate(self.convolutions):
            if depth and not self.static:
                index = nearest_neighbours(features, self.neighbours)
            features = convolution(features, index)
            levels.append(features)
        embedded = self.embedding_norm(self.embedding(torch.cat(levels, -1)))
        embedded = nn.functional.leaky_relu(embedded, DGCNN_SLOPE)
        return self.head(torch.cat([embedded.amax(1), embedded.mean(1)], -1))  # type: ignore[no-any-return]


class PointNet(nn.Module):
    """PointNet encoder of point clouds (Qi et al. 2017), from points [B, n, C] to features [B, F].

    Shared layers, a maximum over the points, and one linear layer. `features` is the width F of the result.
    """

    def __init__(self, config: PointEncoderConfig, channels: int = 3) -> None:
        super().__init__()
        widths = (channels, *config.widths)
        self.layers = nn.ModuleList(nn.Linear(a, b) for a, b in pairwise(widths))
        self.norms = nn.ModuleList(channel_norm(config.norm, width) for width in config.widths)
        self.features = config.features or config.widths[-1]
        self.project = nn.Linear(config.widths[-1], config.features) if config.features else nn.Identity()

    def forward(self, points: Tensor) -> Tensor:
        for layer, norm in zip(self.layers, self.norms, strict=True):
            points = torch.relu(norm(layer(points)))
        return self.project(points.amax(1))  # type: ignore[no-any-return]


def point_encoder(config: PointEncoderConfig, channels: int = 3) -> Dgcnn | PointNet:
    """Encoder of point clouds that a configuration describes; its attribute `features` is the width of its result."""
    return Dgcnn(config, channels) if config.kind == "dgcnn" else PointNet(config, channels)
