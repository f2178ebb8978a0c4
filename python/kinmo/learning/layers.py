"""Small parts that networks are made of. Plain torch, the same on CPU and GPU."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn

from kinmo import _core
from kinmo.config import PointEncoderConfig

DGCNN_SLOPE = 0.2
"""Slope of the LeakyReLU in DGCNN."""


def mlp(widths: Sequence[int], activation: type[nn.Module], last: bool = True) -> nn.Sequential:
    """Linear layers through `widths`, each followed by `activation` (the last one only if `last`)."""
    layers: list[nn.Module] = []
    for index, (before, after) in enumerate(pairwise(widths)):
        layers.append(nn.Linear(before, after))
        if last or index < len(widths) - 2:
            layers.append(activation())
    return nn.Sequential(*layers)


def scatter_mean(values: Tensor, index: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """Means [size, C] of the rows of `values` [M, C] with the same `index` [M], and the counts [size]; zero where there are
    none.
    """
    total = values.new_zeros(size, values.shape[1]).index_add_(0, index, values)
    count = values.new_zeros(size).index_add_(0, index, values.new_ones(len(index)))
    return total / count.clamp(min=1).unsqueeze(1), count


def scatter_max(values: Tensor, index: Tensor, size: int) -> Tensor:
    """Maxima [size, C] of the rows of `values` [M, C] with the same `index` [M]; every index must occur."""
    target = values.new_zeros(size, values.shape[1])
    return target.scatter_reduce(0, index.unsqueeze(1).expand_as(values), values, "amax", include_self=False)


def nearest_neighbours(points: Tensor, count: int) -> Tensor:
    """Indices [B, n, count] of the nearest points of each point of `points` [B, n, C], itself among them."""
    if points.is_cpu and points.dtype == torch.float32 and points.shape[2] == 3:
        return torch.from_numpy(_core.nearest_neighbours(points.detach().numpy(), count))
    squared = points.square().sum(-1)
    affinity = torch.baddbmm(squared.neg().unsqueeze(1), points, points.transpose(1, 2), beta=1.0, alpha=2.0)
    return affinity.topk(min(count, points.shape[1]), dim=-1, sorted=False).indices


def gather_points(features: Tensor, index: Tensor) -> Tensor:
    """Features [B, m, k, C] of the points `index` [B, m, k] of `features` [B, n, C]."""
    _, size, width = features.shape
    return features.reshape(-1, width).index_select(0, _rows(index, size).flatten()).view(*index.shape, width)


def max_over_points(features: Tensor) -> Tensor:
    """Maxima [B, m, C] of `features` [B, m, k, C] over k; of equal ones the first has the gradient."""
    with torch.no_grad():  # a pool finds them fastest, but goes backward slowly where channels come last
        _, places = nn.functional.max_pool2d(features.permute(0, 3, 1, 2), (1, features.shape[2]), return_indices=True)
    return features.flatten(1, 2).gather(1, places.squeeze(3).transpose(1, 2))


def neighbour_max(features: Tensor, index: Tensor) -> Tensor:
    """Maxima [B, m, C] of `features` [B, n, C] over the points `index` [B, m, k]; of equal ones the first has the gradient."""
    if features.is_cpu and features.dtype == torch.float32:
        # told which points they are of, nothing of the size of all pairs is made, nor goes backward
        return features.gather(1, torch.from_numpy(_core.largest_neighbours(features.detach().numpy(), index.numpy())))
    return max_over_points(gather_points(features, index))


def _rows(index: Tensor, size: int) -> Tensor:
    """Indices [B, m, k] of points of each cloud of `size` points as indices into the points of all clouds."""
    return index + torch.arange(len(index), device=index.device).view(-1, 1, 1) * size


def channel_norm(kind: str, width: int) -> nn.Module:
    """A norm over the last axis of [..., C]: `batch`, `group` (about 8 channels a group) or `none`."""
    return nn.Identity() if kind == "none" else _ChannelsLast(kind, width)


class _ChannelsLast(nn.Module):
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
    """max over j of LeakyReLU(norm(W [x_j - x_i, x_i])) (Wang 2019).

    Factored: W [x_j - x_i, x_i] = A x_j + C x_i, so that C x_i leaves the maximum, and with the norm after it no tensor of the
    size of all pairs but the gathered A x_j is made. The parameters are as many.
    """

    def __init__(self, before: int, after: int, norm: str, factored: bool) -> None:
        super().__init__()
        self.neighbour = nn.Linear(before, after, bias=False)
        self.center = nn.Linear(before, after, bias=False)
        self.norm = channel_norm(norm, after)
        self.factored = factored

    def forward(self, features: Tensor, index: Tensor) -> Tensor:
        """`features` [B, n, C], `index` [B, n, k] -> [B, n, C']."""
        near, center = self.neighbour(features), self.center(features)
        if self.factored:
            pooled = neighbour_max(near, index) + center
            return nn.functional.leaky_relu(self.norm(pooled), DGCNN_SLOPE)
        pairs = gather_points(near, index) + (center - near).unsqueeze(2)
        return nn.functional.leaky_relu(self.norm(pairs), DGCNN_SLOPE).amax(2)


class Dgcnn(nn.Module):
    """Points [B, n, C] with their places first -> features [B, F]."""

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
    """Points [B, n, C] -> features [B, F]: shared layers, maximum, one linear layer."""

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
    """The encoder that `config` describes; its width is `.features`."""
    return Dgcnn(config, channels) if config.kind == "dgcnn" else PointNet(config, channels)
