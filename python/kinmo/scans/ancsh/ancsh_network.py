"""Networks of ANCSH: a PointNet++ backbone with one head per quantity (Li et al. 2020, section 4; paper, section 3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from kinmo.config import AncshConfig
from kinmo.scans.ancsh.pointnet2 import PointNetPlusPlus, SharedLayers

KIND = "ancsh"
"""Kind of network in the header of its weights (`kinmo.learning.weights`)."""
GLOBAL_WIDTH = 256
"""Width of the hidden layer of heads on the global feature."""
SIGMOID_SLOPE = 4.0
"""Slope of the inverse of the sigmoid at its middle."""


@dataclass(frozen=True, eq=False)
class PartOutput:
    """Parts and NPCS of n points in each of B scans.

    NPCS are the coordinates of a part in its own box, whose middle is (0.5, 0.5, 0.5) and whose diagonal is 1.

    Attributes:
        parts: Log-probabilities of the part [B, n, C]. C is the number of parts K, or K + 1 with a class for "no part".
        npcs: NPCS of each point on each part [B, n, K, 3], in [0, 1].
    """

    parts: Tensor
    npcs: Tensor


@dataclass(frozen=True, eq=False)
class GlobalOutput:
    """Quantities of B scans as wholes: half sides of the parts' boxes in NPCS [B, K, 3], and pivots in NAOCS [B, K - 1, 3].

    A pivot is the point of the joint's axis that is nearest to the middle of the moving part.
    """

    half_sizes: Tensor
    pivots: Tensor


@dataclass(frozen=True, eq=False)
class JointOutput:
    """Joints of n points in each of B scans.

    NAOCS are the coordinates of the object in its canonical pose: its box has the middle (0.5, 0.5, 0.5) and the diagonal 1.

    Attributes:
        scales: Scales from NPCS to NAOCS [B, n, K], in [0, 1].
        shifts: Shifts from NPCS to NAOCS [B, n, K, 3], in [-1, 1].
        joints: Log-probabilities of the joint near a point [B, n, K]; 0 is no joint, j the joint of part j.
        heatmap: Closeness to the joint axis [B, n]: 1 on the axis, 0 at the radius (`ancsh_targets.JOINT_RADIUS`).
        toward: Unit vectors to the joint axis in NAOCS [B, n, 3].
        axes: Directions of the joint axis in NAOCS [B, n, 3].
        whole: Output for the scans as wholes, if the network has a global head.
    """

    scales: Tensor
    shifts: Tensor
    joints: Tensor
    heatmap: Tensor
    toward: Tensor
    axes: Tensor
    whole: GlobalOutput | None = None

    def naocs(self, npcs: Tensor) -> Tensor:
        """NAOCS [B, n, K, 3] of NPCS [B, n, K, 3]: npcs * scale + shift (Li et al. 2020, section 4)."""
        return npcs * self.scales.unsqueeze(-1) + self.shifts


class PartNetwork(nn.Module):
    """Network named `npcs`: the part of every point, and its place on that part.

    Points have `classes` classes: the `parts`, and one more if points may belong to no part.
    """

    def __init__(self, config: AncshConfig, parts: int, classes: int) -> None:
        super().__init__()
        self.parts = parts
        self.backbone = PointNetPlusPlus(config.centers, config.radii, config.neighbours, config.width, config.dropout)
        features = self.backbone.features
        self.part = nn.Linear(features, classes)
        self.npcs = nn.Sequential(nn.Linear(features, features), nn.Linear(features, 3 * parts))
        self.maps = PartMaps(self.backbone.global_features, parts) if config.maps else None

    def forward(self, points: Tensor) -> PartOutput:
        """Output for points [B, n, 3] in the input frame."""
        return self._part_output(points, *self.backbone(points))

    def _part_output(self, points: Tensor, features: Tensor, whole: Tensor) -> PartOutput:
        npcs = self.npcs(features).view(*features.shape[:2], self.parts, 3)
        if self.maps is not None:
            npcs = npcs + self.maps(points, whole)
        return PartOutput(torch.log_softmax(self.part(features), -1), torch.sigmoid(npcs))


def global_layers(features: int, outputs: int) -> nn.Sequential:
    """Layers from the global feature [..., features] to [..., outputs]; before training the outputs are zero."""
    last = nn.Linear(GLOBAL_WIDTH, outputs)
    nn.init.zeros_(last.weight)
    nn.init.zeros_(last.bias)
    return nn.Sequential(nn.Linear(features, GLOBAL_WIDTH), nn.LayerNorm(GLOBAL_WIDTH), nn.ReLU(), last)


class PartMaps(nn.Module):
    """A linear map from points to the NPCS of every part, predicted from the global feature.

    The NPCS of a rigid part are a linear map of its points. The sigmoid after it bends the map a little, and the head for
    single points adds corrections.
    """

    def __init__(self, features: int, parts: int) -> None:
        super().__init__()
        self.parts = parts
        self.layers = global_layers(features, 12 * parts)

    def forward(self, points: Tensor, whole: Tensor) -> Tensor:
        """Logits of NPCS [B, n, K, 3], from points [B, n, 3] and global features [B, 1, C]."""
        maps = self.layers(whole).view(len(points), self.parts, 3, 4)
        matrices, shifts = maps[..., :3], maps[:, None, :, :, 3]
        mapped: Tensor = torch.einsum("bkij,bnj->bnki", matrices, points) + shifts
        return SIGMOID_SLOPE * mapped


class GlobalHead(nn.Module):
    """Head for quantities that are the same for all points of a scan, predicted from the global feature."""

    def __init__(self, features: int, parts: int) -> None:
        super().__init__()
        self.parts = parts
        self.layers = global_layers(features, 3 * parts + 3 * (parts - 1))

    def forward(self, whole: Tensor) -> GlobalOutput:
        """Output for the global features [B, 1, C] of B scans."""
        sizes, pivots = self.layers(whole).view(len(whole), -1, 3).split((self.parts, self.parts - 1), 1)
        return GlobalOutput(0.5 * torch.nn.functional.normalize(sizes.exp(), dim=-1), 0.5 + pivots)


class AncshNetwork(PartNetwork):
    """Network named `ancsh`: all quantities of ANCSH."""

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
        self.global_head = GlobalHead(self.backbone.global_features, parts) if config.global_head else None
        if not config.global_head:
            self.confidence = nn.Linear(features, 1)  # a head of the release without a loss, whose output nothing uses

    def forward_all(self, points: Tensor) -> tuple[PartOutput, JointOutput]:
        """Outputs for points [B, n, 3] in the input frame."""
        features, whole = self.backbone(points)
        near = self.near_joints(features)
        joints = JointOutput(
            scales=torch.sigmoid(self.scale(features)),
            shifts=torch.tanh(self.shift(features)).view(*features.shape[:2], self.parts, 3),
            joints=torch.log_softmax(self.joint(near), -1),
            heatmap=torch.sigmoid(self.heatmap(near)).squeeze(-1),
            toward=torch.tanh(self.toward(near)),
            axes=torch.tanh(self.axis(near)),
            whole=None if self.global_head is None else self.global_head(whole),
        )
        return self._part_output(points, features, whole), joints


def at_part(values: Tensor, parts: Tensor) -> Tensor:
    """Values [B, n, 3] out of [B, n, K, 3], at `parts` [B, n]; for points of no part those of the last one."""
    index = parts.clamp(max=values.shape[2] - 1).view(*parts.shape, 1, 1).expand(-1, -1, 1, 3)
    return torch.gather(values, 2, index).squeeze(2)
