"""Losses of ANCSH (Li et al. 2020, section 4; weights in `AncshWeights`)."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from kinmo.config import AncshConfig, MeanOver
from kinmo.scans.ancsh.ancsh_network import JointOutput, PartOutput, at_part


@dataclass(frozen=True, eq=False)
class ScanBatch:
    """B labelled scans of n points each, of objects with K parts. Quantities are those of the networks' outputs.

    Attributes:
        points: Points in the input frame [B, n, 3].
        parts: True part of each point [B, n]; C - 1 for a point of no part.
        npcs: True NPCS on that part [B, n, 3].
        naocs: True NAOCS [B, n, 3].
        joints: Joint near each point [B, n]; 0 for none.
        heatmap: Closeness to the axis of that joint [B, n].
        toward: Unit vector to that axis in NAOCS [B, n, 3].
        axes: Direction of that axis in NAOCS [B, n, 3].
        has_pivot: Whether that axis has a place [B, n]; the axis of a slider has none.
        half_sizes: Half sides of the parts' boxes in NPCS [B, K, 3].
        pivots: Points on the joint axes in NAOCS [B, K - 1, 3].
        is_line: Whether the joint's axis has a place [B, K - 1].
    """

    points: Tensor
    parts: Tensor
    npcs: Tensor
    naocs: Tensor
    joints: Tensor
    heatmap: Tensor
    toward: Tensor
    axes: Tensor
    has_pivot: Tensor
    half_sizes: Tensor
    pivots: Tensor
    is_line: Tensor

    def to(self, device: torch.device | str) -> ScanBatch:
        """The same batch on a device."""
        return ScanBatch(*(value.to(device) for value in vars(self).values()))


def relaxed_iou_loss(log_probabilities: Tensor, truth: Tensor) -> Tensor:
    """One minus the mean relaxed IoU of the classes: a scalar in [0, 1] (Li et al. 2020, section 4).

    The relaxed IoU of a class is p.g / (sum p + sum g - p.g), with probabilities p and true indicators g over the points.
    Log-probabilities are [B, n, C], true classes [B, n].
    """
    probabilities = log_probabilities.exp()
    marked = torch.nn.functional.one_hot(truth, log_probabilities.shape[-1]).to(probabilities.dtype)
    shared = (probabilities * marked).sum(1)
    union = probabilities.sum(1) + marked.sum(1) - shared
    return 1.0 - (shared / (union + 1e-6)).mean()


def part_losses(output: PartOutput, batch: ScanBatch, mean_over: MeanOver) -> dict[str, Tensor]:
    """Losses `parts` (relaxed IoU) and `npcs` (mean distance at the true part), scalars by name.

    Means are over all points, as in the release, or over the visible parts.
    """
    return {
        "parts": relaxed_iou_loss(output.parts, batch.parts),
        "npcs": _distance_at_true_part(output.npcs, batch.npcs, batch.parts, mean_over),
    }


def joint_losses(parts: PartOutput, output: JointOutput, batch: ScanBatch, mean_over: MeanOver) -> dict[str, Tensor]:
    """Losses `naocs`, `joints`, `heatmap`, `toward` and `axes`; with a global head also `sizes` and `pivots`.

    `heatmap`, `toward` and `axes` are means over all points, although only points near a joint contribute (Li et al. 2020).
    `sizes` compares logarithms: what counts for a box are ratios. `parts` is the output of the same network, whose NPCS give
    `naocs`; otherwise as in `part_losses`.
    """
    near = (batch.joints > 0).to(batch.points.dtype)
    near_line = near * batch.has_pivot
    losses = {
        "naocs": _distance_at_true_part(output.naocs(parts.npcs), batch.naocs, batch.parts, mean_over),
        "joints": relaxed_iou_loss(output.joints, batch.joints),
        "heatmap": ((output.heatmap - batch.heatmap).abs() * near_line).mean(),
        "toward": (torch.linalg.vector_norm(output.toward - batch.toward, dim=-1) * near_line).mean(),
        "axes": (torch.linalg.vector_norm(output.axes - batch.axes, dim=-1) * near).mean(),
    }
    if output.whole is not None:
        losses["sizes"] = (output.whole.half_sizes / batch.half_sizes).log().abs().mean()
        distances = torch.linalg.vector_norm(output.whole.pivots - batch.pivots, dim=-1)
        losses["pivots"] = (distances * batch.is_line).mean()
    return losses


def total_loss(losses: dict[str, Tensor], config: AncshConfig) -> Tensor:
    """Sum of the losses, weighted by `AncshConfig.weights`."""
    return torch.stack([getattr(config.weights, name) * loss for name, loss in losses.items()]).sum()


def _distance_at_true_part(predicted: Tensor, truth: Tensor, parts: Tensor, mean_over: MeanOver) -> Tensor:
    """Mean distance of `predicted` [B, n, K, 3], taken at the true `parts` [B, n], from `truth` [B, n, 3].

    With "points" the mean is over all points, and points of no part count as zero. With "parts" it is over the points of each
    visible part of a scan, and then over these parts.
    """
    count = predicted.shape[2]
    known = parts < count
    distances: Tensor = torch.linalg.vector_norm(at_part(predicted, parts) - truth, dim=-1) * known
    if mean_over == "points":
        return distances.mean()
    marked = torch.nn.functional.one_hot(parts.clamp(max=count - 1), count).to(distances.dtype) * known.unsqueeze(-1)
    visible = marked.sum(1)
    means = (distances.unsqueeze(-1) * marked).sum(1) / visible.clamp(min=1)
    return means.sum() / (visible > 0).sum().clamp(min=1)
