"""The two networks of ANCSH (Li 2020, section 4; the paper, section 3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from kinmo.config import AncshConfig
from kinmo.scans.ancsh.pointnet2 import PointNetPlusPlus, SharedLayers

KIND = "ancsh"


@dataclass(frozen=True, eq=False)
class PartAnswers:
    """For n points of B scans: `parts` [B, n, C] log-probabilities of the part, `npcs` [B, n, K, 3] in [0, 1]."""

    parts: Tensor
    npcs: Tensor


@dataclass(frozen=True, eq=False)
class LayoutAnswers:
    """For B scans as wholes, of the object that is seen in each, with K parts.

    `half_sizes` [B, K, 3] of the parts' boxes in NPCS; `pivots` [B, K - 1, 3] in NAOCS, where the axes of the joints of parts 1
    and up are nearest to the middles of these parts.
    """

    half_sizes: Tensor
    pivots: Tensor


@dataclass(frozen=True, eq=False)
class JointAnswers:
    """For n points of B scans.

    `scales` [B, n, K] in [0, 1] and `shifts` [B, n, K, 3] in [-1, 1] take NPCS to NAOCS. `joints` [B, n, K] are
    log-probabilities of the joint that a point is near to (0: none), `heatmap` [B, n] is 1 on its axis and 0 where that is
    `reach` away, `toward` [B, n, 3] the unit vector to the axis and `axes` [B, n, 3] its direction, in NAOCS. `layout` is what
    the scans say as wholes, where they are asked.
    """

    scales: Tensor
    shifts: Tensor
    joints: Tensor
    heatmap: Tensor
    toward: Tensor
    axes: Tensor
    layout: LayoutAnswers | None = None

    def naocs(self, npcs: Tensor) -> Tensor:
        """Places [B, n, K, 3] on the whole object of NPCS [B, n, K, 3]."""
        return npcs * self.scales.unsqueeze(-1) + self.shifts


class PartNetwork(nn.Module):
    """Which part every point is of, and where on it: the network that is called `npcs`."""

    def __init__(self, config: AncshConfig, parts: int, classes: int) -> None:
        """`classes` are the `parts`, and one more where points may be of none."""
        super().__init__()
        self.parts = parts
        self.backbone = PointNetPlusPlus(
            config.centers, config.radii, config.neighbours, config.width, config.distance_power, config.dropout
        )
        features = self.backbone.features
        self.part = nn.Linear(features, classes)
        self.npcs = nn.Sequential(nn.Linear(features, features), nn.Linear(features, 3 * parts))
        self.maps = PartMaps(self.backbone.whole_features, parts) if config.maps else None

    def forward(self, points: Tensor) -> PartAnswers:
        """`points` [B, n, 3]."""
        return self._of(points, *self.backbone(points))

    def _of(self, points: Tensor, features: Tensor, whole: Tensor) -> PartAnswers:
        npcs = self.npcs(features).view(*features.shape[:2], self.parts, 3)
        if self.maps is not None:
            npcs = npcs + self.maps(points, whole)
        return PartAnswers(torch.log_softmax(self.part(features), -1), torch.sigmoid(npcs))


def whole_layers(features: int, answers: int) -> nn.Sequential:
    """From the features of a scan as a whole to `answers`, at first with the same for all scans."""
    hidden = 256
    last = nn.Linear(hidden, answers)
    nn.init.zeros_(last.weight)
    nn.init.zeros_(last.bias)
    return nn.Sequential(nn.Linear(features, hidden), nn.LayerNorm(hidden), nn.ReLU(), last)


class PartMaps(nn.Module):
    """A linear map of the points for every part, of what the scan is as a whole.

    Of a rigid part NPCS are one, but for the bend of the sigmoid: so what every point says need only correct it.
    """

    SLOPE = 4.0
    """Of the inverse of the sigmoid, in the middle."""

    def __init__(self, features: int, parts: int) -> None:
        super().__init__()
        self.parts = parts
        self.layers = whole_layers(features, 12 * parts)

    def forward(self, points: Tensor, whole: Tensor) -> Tensor:
        """`points` [B, n, 3], `whole` [B, 1, C] -> [B, n, K, 3]."""
        maps = self.layers(whole).view(len(points), self.parts, 3, 4)
        matrices, shifts = maps[..., :3], maps[:, None, :, :, 3]
        mapped: Tensor = torch.einsum("bkij,bnj->bnki", matrices, points) + shifts
        return self.SLOPE * mapped


class LayoutHead(nn.Module):
    """What is the same for all points of a scan, and so is asked of the scan as a whole."""

    def __init__(self, features: int, parts: int) -> None:
        super().__init__()
        self.parts = parts
        self.layers = whole_layers(features, 3 * parts + 3 * (parts - 1))

    def forward(self, whole: Tensor) -> LayoutAnswers:
        """`whole` [B, 1, C]."""
        sizes, pivots = self.layers(whole).view(len(whole), -1, 3).split((self.parts, self.parts - 1), 1)
        return LayoutAnswers(0.5 * torch.nn.functional.normalize(sizes.exp(), dim=-1), 0.5 + pivots)


class AncshNetwork(PartNetwork):
    """All that ANCSH predicts: the network that is called `ancsh`."""

    def __init__(self, config: AncshConfig, parts: int, classes: int) -> None:
        super().__init__(config, parts, classes)
        features = self.backbone.features
        self.scale = nn.Linear(features, parts)
        self.shift = nn.Linear(features, 3 * parts)
        wide = (features, features)
        self.near_joints = nn.Sequential(
            SharedLayers(wide), nn.Dropout(config.dropout), SharedLayers(wide), nn.Dropout(config.dropout)
        )
        self.axis = nn.Linear(features, 3)
        self.toward = nn.Linear(features, 3)
        self.heatmap = nn.Linear(features, 1)
        self.joint = nn.Linear(features, parts)
        self.layout = LayoutHead(self.backbone.whole_features, parts) if config.layout else None
        if not config.layout:
            self.confidence = nn.Linear(features, 1)  # a head of the release that no loss trains and nothing reads

    def forward_all(self, points: Tensor) -> tuple[PartAnswers, JointAnswers]:
        """`points` [B, n, 3]."""
        features, whole = self.backbone(points)
        near = self.near_joints(features)
        joints = JointAnswers(
            scales=torch.sigmoid(self.scale(features)),
            shifts=torch.tanh(self.shift(features)).view(*features.shape[:2], self.parts, 3),
            joints=torch.log_softmax(self.joint(near), -1),
            heatmap=torch.sigmoid(self.heatmap(near)).squeeze(-1),
            toward=torch.tanh(self.toward(near)),
            axes=torch.tanh(self.axis(near)),
            layout=None if self.layout is None else self.layout(whole),
        )
        return self._of(points, features, whole), joints
