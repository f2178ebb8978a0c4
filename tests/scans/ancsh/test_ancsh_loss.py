"""Losses of ANCSH, compared with values worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest
import torch
from tiny_ancsh import TINY, two_scans

from kinmo.config import MeanOver, load_config
from kinmo.scans.ancsh.ancsh_loss import ScanBatch, joint_losses, part_losses, relaxed_iou_loss, total_loss
from kinmo.scans.ancsh.ancsh_network import GlobalOutput, JointOutput, PartNetwork, PartOutput
from kinmo.scans.files.scan_file import ScanFile


def perfect_outputs(file: ScanFile, batch: ScanBatch) -> tuple[PartOutput, JointOutput]:
    """Perfect outputs of the networks for the two scans of a batch."""
    parts = file.structure.part_count

    def certain(labels: torch.Tensor) -> torch.Tensor:
        return torch.log(torch.nn.functional.one_hot(labels, parts).float().clamp(min=1e-12))

    scales = torch.from_numpy(file.extents.diagonals).float().expand(2, TINY.points, -1)
    shifts = torch.tensor(file.extents.centers).float() + 0.5 - 0.5 * scales.unsqueeze(-1)
    output = PartOutput(certain(batch.parts), batch.npcs.unsqueeze(2).expand(-1, -1, parts, -1))
    whole = GlobalOutput(batch.half_sizes, batch.pivots)
    return output, JointOutput(scales, shifts, certain(batch.joints), batch.heatmap, batch.toward, batch.axes, whole)


def test_perfect_outputs_have_no_loss(file: ScanFile) -> None:
    batch = two_scans(file)
    output, joints = perfect_outputs(file, batch)
    assert set(batch.joints.unique().tolist()) == set(range(file.structure.part_count)), "a class without points has no IoU"
    for mean_over in get_args(MeanOver):
        for name, loss in (part_losses(output, batch, mean_over) | joint_losses(output, joints, batch, mean_over)).items():
            assert loss.item() == pytest.approx(0.0, abs=1e-5), name


def test_the_losses_of_the_paper_are_weighted_distances_over_all_points(file: ScanFile) -> None:
    batch = two_scans(file)
    output, joints = perfect_outputs(file, batch)
    near = (batch.joints > 0).float().mean().item()
    hinged = ((batch.joints > 0) & batch.has_pivot.bool()).float().mean().item()
    assert 0.0 < hinged < near < 1.0
    shift = torch.tensor([0.3, 0.0, 0.4])
    off = replace(
        joints,
        shifts=joints.shifts + shift,
        heatmap=joints.heatmap + 0.2,
        toward=joints.toward + shift,
        axes=joints.axes + shift,
        whole=None,
    )
    away = replace(output, npcs=output.npcs + shift)
    found = part_losses(away, batch, "points") | joint_losses(output, off, batch, "points")
    del found["parts"], found["joints"]
    expected = {"npcs": 0.5, "naocs": 0.5, "heatmap": 0.2 * hinged, "toward": 0.5 * hinged, "axes": 0.5 * near}
    assert {name: loss.item() for name, loss in found.items()} == pytest.approx(expected, abs=1e-4)
    weighted = 10.0 * 0.5 + 1.0 * 0.5 + 5.0 * 0.2 * hinged + 5.0 * 0.5 * hinged + 0.2 * 0.5 * near
    paper = load_config("paper").ancsh
    assert total_loss(found, paper).item() == pytest.approx(weighted, abs=1e-3)
    one = torch.tensor(1.0)
    assert total_loss({"parts": one, "joints": one}, paper).item() == pytest.approx(2.0)


def test_the_relaxed_iou_of_certain_outputs_is_the_iou_of_sets() -> None:
    truth = torch.tensor([[0, 0, 0, 1]])
    output = torch.log(torch.tensor([[[1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]]).clamp(min=1e-12))
    assert relaxed_iou_loss(output, truth).item() == pytest.approx(1.0 - 0.5 * (2 / 3 + 1 / 2), abs=1e-5)


def labelled(points: torch.Tensor, labels: torch.Tensor) -> ScanBatch:
    """Scan whose `points` [1, n, 3] have the parts `labels` [1, n], all at the same position and near no joint."""
    nowhere, never = torch.zeros_like(points), torch.zeros(labels.shape)
    whole = torch.ones(1, 2, 3), torch.zeros(1, 1, 3), torch.ones(1, 1, dtype=torch.bool)
    return ScanBatch(points, labels, nowhere, nowhere, never.long(), never, nowhere, nowhere, never > 0, *whole)


def test_points_of_no_part_train_the_classification_alone() -> None:
    torch.manual_seed(0)
    network = PartNetwork(TINY, 2, 3)
    points = torch.rand(1, 64, 3)
    outputs = network(points)
    batch = labelled(points, torch.full((1, 64), 2))
    for mean_over in get_args(MeanOver):
        losses = part_losses(outputs, batch, mean_over)
        assert losses["npcs"].item() == 0.0
        assert losses["parts"].item() > 0.0


@pytest.mark.parametrize("lost", range(3))
def test_every_visible_part_counts_equally_however_few_points_it_has(lost: int) -> None:
    points = torch.rand(1, 8, 3)
    labels = torch.tensor([[0, 0, 0, 0, 0, 1, 1, 3]])  # part 2 is invisible, and one point has no part
    batch = replace(labelled(points, labels), npcs=points, naocs=points)
    npcs = points.unsqueeze(2).repeat(1, 1, 3, 1)
    npcs[..., lost, 0] += 0.6
    output = PartOutput(torch.zeros(1, 8, 4), npcs)
    scales, shifts, joints = torch.ones(1, 8, 3), torch.zeros(1, 8, 3, 3), torch.zeros(1, 8, 3)
    outputs = JointOutput(scales, shifts, joints, heatmap=joints[..., 0], toward=joints, axes=joints)
    expected = {"parts": (0.3, 0.3, 0.0), "points": (0.6 * 5 / 8, 0.6 * 2 / 8, 0.0)}
    for mean_over in get_args(MeanOver):
        losses = part_losses(output, batch, mean_over) | joint_losses(output, outputs, batch, mean_over)
        for name in ("npcs", "naocs"):
            assert losses[name].item() == pytest.approx(expected[mean_over][lost], abs=1e-6), (name, mean_over)
