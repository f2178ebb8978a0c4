"""The losses of ANCSH."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from kinmo.config import AncshConfig, MeanOver
from kinmo.scans.ancsh.ancsh_network import JointAnswers, PartAnswers


@dataclass(frozen=True, eq=False)
class ScanBatch:
    """B labelled scans of n points each.

    `points` [B, n, 3] as the network sees them; `parts` [B, n] (C - 1 for a point of none), `npcs` and `naocs` [B, n, 3] of the
    part that the point is of, `joints` [B, n] the joint that it is near to, 0 for none. Where it is near to one, `heatmap`
    [B, n], `toward` and `axes` [B, n, 3] are as in `JointAnswers`, and `has_pivot` [B, n] says that its axis has a place.
    `half_sizes` [B, K, 3] and `pivots` [B, K - 1, 3] are as in `LayoutAnswers`; `is_line` [B, K - 1]: the joint has a pivot.
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
        return ScanBatch(*(value.to(device) for value in vars(self).values()))


def relaxed_iou_loss(logarithms: Tensor, truth: Tensor) -> Tensor:
    """1 - the mean relaxed IoU of the classes: `logarithms` [B, n, C] of probabilities, `truth` [B, n]."""
    probabilities = logarithms.exp()
    marked = torch.nn.functional.one_hot(truth, logarithms.shape[-1]).to(probabilities.dtype)
    shared = (probabilities * marked).sum(1)
    union = probabilities.sum(1) + marked.sum(1) - shared
    return 1.0 - (shared / (union + 1e-6)).mean()


def part_losses(answers: PartAnswers, batch: ScanBatch, mean_over: MeanOver) -> dict[str, Tensor]:
    """`parts` and `npcs`."""
    return {
        "parts": relaxed_iou_loss(answers.parts, batch.parts),
        "npcs": _apart(answers.npcs, batch.npcs, batch.parts, mean_over),
    }


def joint_losses(parts: PartAnswers, answers: JointAnswers, batch: ScanBatch, mean_over: MeanOver) -> dict[str, Tensor]:
    """`naocs`, `joints`, `heatmap`, `toward` and `axes`, the last three over all points though few are near to a joint; and
    `sizes` and `pivots`, where scans are asked as wholes.
    """
    near = (batch.joints > 0).to(batch.points.dtype)
    placed = near * batch.has_pivot
    losses = {
        "naocs": _apart(answers.naocs(parts.npcs), batch.naocs, batch.parts, mean_over),
        "joints": relaxed_iou_loss(answers.joints, batch.joints),
        "heatmap": ((answers.heatmap - batch.heatmap).abs() * placed).mean(),
        "toward": (torch.linalg.vector_norm(answers.toward - batch.toward, dim=-1) * placed).mean(),
        "axes": (torch.linalg.vector_norm(answers.axes - batch.axes, dim=-1) * near).mean(),
    }
    if answers.layout is not None:
        # of boxes ratios count: a door a tenth of its width too wide is as far off as one that is as much too thick
        losses["sizes"] = (answers.layout.half_sizes / batch.half_sizes).log().abs().mean()
        off = torch.linalg.vector_norm(answers.layout.pivots - batch.pivots, dim=-1)
        losses["pivots"] = (off * batch.is_line).mean()
    return losses


def total(losses: dict[str, Tensor], config: AncshConfig) -> Tensor:
    """The weighted sum."""
    return torch.stack([getattr(config.weights, name) * loss for name, loss in losses.items()]).sum()


def _apart(found: Tensor, truth: Tensor, parts: Tensor, mean_over: MeanOver) -> Tensor:
    """Mean distance of `found` [B, n, K, 3], at the true part, from `truth` [B, n, 3].

    Over all points, those of no part counting as zero; or over those of each part that a scan shows, and then over these parts.
    """
    count = found.shape[2]
    known = parts < count
    own = torch.where(known, parts, 0)
    index = own.view(*parts.shape, 1, 1).expand(-1, -1, 1, 3)
    distances: Tensor = torch.linalg.vector_norm(torch.gather(found, 2, index).squeeze(2) - truth, dim=-1) * known
    if mean_over == "points":
        return distances.mean()
    marked = torch.nn.functional.one_hot(own, count).to(distances.dtype) * known.unsqueeze(-1)
    shown = marked.sum(1)
    means = (distances.unsqueeze(-1) * marked).sum(1) / shown.clamp(min=1)
    return means.sum() / (shown > 0).sum().clamp(min=1)
