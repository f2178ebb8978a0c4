"""The losses of ANCSH, by worked values."""

from __future__ import annotations

from dataclasses import replace
from typing import get_args

import pytest
import torch
from tiny_ancsh import TINY, two_scans

from kinmo.config import MeanOver, load_config
from kinmo.scans.ancsh.ancsh_loss import ScanBatch, joint_losses, part_losses, relaxed_iou_loss, total
from kinmo.scans.ancsh.ancsh_network import JointAnswers, LayoutAnswers, PartAnswers, PartNetwork
from kinmo.scans.files.scan_file import ScanFile


def right_answers(file: ScanFile, batch: ScanBatch) -> tuple[PartAnswers, JointAnswers]:
    """What there is to say of the two scans of a batch."""
    parts = file.structure.part_count

    def sure(labels: torch.Tensor) -> torch.Tensor:
        return torch.log(torch.nn.functional.one_hot(labels, parts).float().clamp(min=1e-12))

    scales = torch.from_numpy(file.extents.diagonals).float().expand(2, TINY.points, -1)
    shifts = torch.tensor(file.extents.centers).float() + 0.5 - 0.5 * scales.unsqueeze(-1)
    said = PartAnswers(sure(batch.parts), batch.npcs.unsqueeze(2).expand(-1, -1, parts, -1))
    whole = LayoutAnswers(batch.half_sizes, batch.pivots)
    return said, JointAnswers(scales, shifts, sure(batch.joints), batch.heatmap, batch.toward, batch.axes, whole)


def test_the_loss_of_right_answers_is_zero(file: ScanFile) -> None:
    batch = two_scans(file)
    said, joints = right_answers(file, batch)
    assert set(batch.joints.unique().tolist()) == set(range(file.structure.part_count)), "what does not occur has no IoU"
    for mean_over in get_args(MeanOver):
        for name, loss in (part_losses(said, batch, mean_over) | joint_losses(said, joints, batch, mean_over)).items():
            assert loss.item() == pytest.approx(0.0, abs=1e-5), name


def test_the_papers_losses_are_weighed_distances_over_all_points(file: ScanFile) -> None:
    batch = two_scans(file)
    said, joints = right_answers(file, batch)
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
        layout=None,
    )
    away = replace(said, npcs=said.npcs + shift)
    found = part_losses(away, batch, "points") | joint_losses(said, off, batch, "points")
    del found["parts"], found["joints"]
    expected = {"npcs": 0.5, "naocs": 0.5, "heatmap": 0.2 * hinged, "toward": 0.5 * hinged, "axes": 0.5 * near}
    assert {name: loss.item() for name, loss in found.items()} == pytest.approx(expected, abs=1e-4)
    weighed = 10.0 * 0.5 + 1.0 * 0.5 + 5.0 * 0.2 * hinged + 5.0 * 0.5 * hinged + 0.2 * 0.5 * near
    paper = load_config("paper").ancsh
    assert total(found, paper).item() == pytest.approx(weighed, abs=1e-3)
    one = torch.tensor(1.0)
    assert total({"parts": one, "joints": one}, paper).item() == pytest.approx(2.0)


def test_the_relaxed_iou_is_that_of_sets_for_sure_answers() -> None:
    truth = torch.tensor([[0, 0, 0, 1]])
    said = torch.log(torch.tensor([[[1.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]]]).clamp(min=1e-12))
    assert relaxed_iou_loss(said, truth).item() == pytest.approx(1.0 - 0.5 * (2 / 3 + 1 / 2), abs=1e-5)


def labelled(points: torch.Tensor, labels: torch.Tensor) -> ScanBatch:
    """A scan whose `points` [1, n, 3] are of the parts `labels` [1, n], all in one place and near to no joint."""
    nowhere, never = torch.zeros_like(points), torch.zeros(labels.shape)
    whole = torch.ones(1, 2, 3), torch.zeros(1, 1, 3), torch.ones(1, 1, dtype=torch.bool)
    return ScanBatch(points, labels, nowhere, nowhere, never.long(), never, nowhere, nowhere, never > 0, *whole)


def test_points_of_no_part_teach_nothing_but_that() -> None:
    torch.manual_seed(0)
    network = PartNetwork(TINY, 2, 3)
    points = torch.rand(1, 64, 3)
    answers = network(points)
    batch = labelled(points, torch.full((1, 64), 2))
    for mean_over in get_args(MeanOver):
        losses = part_losses(answers, batch, mean_over)
        assert losses["npcs"].item() == 0.0
        assert losses["parts"].item() > 0.0


@pytest.mark.parametrize("lost", range(3))
def test_places_on_a_part_count_however_few_of_its_points_are_seen(lost: int) -> None:
    points = torch.rand(1, 8, 3)
    labels = torch.tensor([[0, 0, 0, 0, 0, 1, 1, 3]])  # nothing is seen of part 2, and a point is of none
    batch = replace(labelled(points, labels), npcs=points, naocs=points)
    npcs = points.unsqueeze(2).repeat(1, 1, 3, 1)
    npcs[..., lost, 0] += 0.6
    said = PartAnswers(torch.zeros(1, 8, 4), npcs)
    scales, shifts, joints = torch.ones(1, 8, 3), torch.zeros(1, 8, 3, 3), torch.zeros(1, 8, 3)
    answers = JointAnswers(scales, shifts, joints, heatmap=joints[..., 0], toward=joints, axes=joints)
    expected = {"parts": (0.3, 0.3, 0.0), "points": (0.6 * 5 / 8, 0.6 * 2 / 8, 0.0)}
    for mean_over in get_args(MeanOver):
        losses = part_losses(said, batch, mean_over) | joint_losses(said, answers, batch, mean_over)
        for name in ("npcs", "naocs"):
            assert losses[name].item() == pytest.approx(expected[mean_over][lost], abs=1e-6), (name, mean_over)
