"""Networks of ANCSH: numbers of parameters, outputs before training, and losses on any device."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import torch
from tiny_ancsh import two_scans

from kinmo.config import AncshConfig, load_config
from kinmo.scans.ancsh import pointnet2
from kinmo.scans.ancsh.ancsh_loss import ScanBatch, joint_losses, part_losses, total_loss
from kinmo.scans.ancsh.ancsh_network import AncshNetwork, GlobalHead, PartMaps, PartNetwork
from kinmo.scans.ancsh.pointnet2 import PointLevel, point_levels
from kinmo.scans.ancsh.scan_batches import ScanData
from kinmo.scans.files.scan_file import ScanFile

UNUSED = {"confidence.weight", "confidence.bias"}
"""Parameters of the release that no loss trains."""


def shared(*widths: int) -> int:
    """Number of parameters of layers without a bias, each with a batch norm."""
    return sum(before * after + 2 * after for before, after in pairwise(widths))


def linear(before: int, after: int) -> int:
    return before * after + after


@pytest.mark.parametrize("parts", [2, 3, 5])
def test_the_paper_networks_have_as_many_parameters_as_the_printed_sizes_say(parts: int) -> None:
    backbone = shared(3, 64, 64, 128) + shared(3 + 128, 128, 128, 256) + shared(3 + 256, 256, 512, 1024)
    backbone += shared(1024 + 256, 256, 256) + shared(256 + 128, 256, 128) + shared(128 + 3, 128, 128, 128)
    backbone += shared(128, 128)
    own = linear(128, parts) + linear(128, 128) + linear(128, 3 * parts)
    joints = linear(128, parts) + linear(128, 3 * parts) + shared(128, 128, 128)
    joints += linear(128, 3) + linear(128, 3) + linear(128, 1) + linear(128, parts)
    joints += linear(128, 1)  # the unused confidence
    config = load_config("paper").ancsh
    count = [sum(p.numel() for p in kind(config, parts, parts).parameters()) for kind in (PartNetwork, AncshNetwork)]
    assert count == [backbone + own, backbone + own + joints]


def test_an_untrained_global_head_predicts_the_same_for_all_scans() -> None:
    found = GlobalHead(16, 3)(torch.rand(4, 1, 16))
    torch.testing.assert_close(found.half_sizes, torch.full((4, 3, 3), 0.5 / 3**0.5))
    torch.testing.assert_close(found.pivots, torch.full((4, 2, 3), 0.5))


def test_a_part_map_is_linear_and_zero_before_training() -> None:
    torch.manual_seed(0)
    maps = PartMaps(16, 3)
    points, whole = torch.rand(2, 50, 3), torch.rand(2, 1, 16)
    assert (maps(points, whole) == 0.0).all()
    torch.nn.init.normal_(maps.layers[-1].weight)
    found, middles = maps(points, whole), maps(points.mean(1, keepdim=True), whole)
    assert found.shape == (2, 50, 3, 3)
    torch.testing.assert_close(found.mean(1, keepdim=True), middles, rtol=1e-4, atol=1e-5)
    assert not torch.allclose(found[:, :, 0], found[:, :, 1])


def test_the_paper_networks_have_dropout_after_each_joint_layer() -> None:
    layers = AncshNetwork(load_config("paper").ancsh, 3, 3).near_joints
    assert [layer.p for layer in layers if isinstance(layer, torch.nn.Dropout)] == [0.5, 0.5]
    assert isinstance(layers[-1], torch.nn.Dropout)


def test_the_paper_networks_take_a_step(file: ScanFile) -> None:
    config = replace(load_config("paper").ancsh, batch_frames=2)
    batch = ScanData([file], [file], config).batch([(file, 0), (file, 1)], np.random.default_rng(0))
    network = AncshNetwork(config, file.structure.part_count, file.structure.part_count)
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    before = {name: p.detach().clone() for name, p in network.named_parameters()}
    for _ in range(2):
        parts, joints = network.forward_all(batch.points)
        losses = part_losses(parts, batch, config.mean_over) | joint_losses(parts, joints, batch, config.mean_over)
        loss = total_loss(losses, config)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    assert torch.isfinite(loss)
    unchanged = {name for name, parameters in network.named_parameters() if torch.equal(before[name], parameters)}
    assert unchanged == UNUSED


def losses_on(device: str, file: ScanFile, config: AncshConfig, batch: ScanBatch) -> dict[str, float | None]:
    """Losses of new networks after a forward and a backward pass; None on `meta`, where tensors have no values."""
    torch.manual_seed(0)
    parts = file.structure.part_count
    found: dict[str, torch.Tensor] = {}
    for kind in (PartNetwork, AncshNetwork):
        network, seen = kind(config, parts, parts).to(device), batch.to(device)
        if isinstance(network, AncshNetwork):
            output, joints = network.forward_all(seen.points)
            found |= part_losses(output, seen, config.mean_over) | joint_losses(output, joints, seen, config.mean_over)
            total_loss(found, config).backward()
        else:
            found |= part_losses(network(seen.points), seen, config.mean_over)
            total_loss(found, config).backward()
        gradients = [own.grad for name, own in network.named_parameters() if name not in UNUSED]
        assert all(each is not None and each.device.type == device for each in gradients)
    assert all(loss.device.type == device for loss in found.values())
    return {name: None if device == "meta" else loss.item() for name, loss in found.items()}


@pytest.mark.parametrize("name", ["small", "paper"])
def test_networks_and_losses_stay_on_the_device_of_their_tensors(
    file: ScanFile, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tensors on the device `meta` have no values, and anything made on the CPU would not fit them."""

    def levels_on_device(points: torch.Tensor, *grouping: Any) -> tuple[PointLevel, ...]:
        levels = point_levels(torch.rand(points.shape), *grouping)  # random points, as those on `meta` have no coordinates
        return tuple(PointLevel(*(each.to(points.device) for each in vars(level).values())) for level in levels)

    monkeypatch.setattr(pointnet2, "point_levels", levels_on_device)
    losses_on("meta", file, load_config(name).ancsh, two_scans(file))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device here")
@pytest.mark.parametrize("name", ["small", "paper"])
def test_a_gpu_gives_the_same_losses(file: ScanFile, name: str) -> None:
    config = replace(load_config(name).ancsh, dropout=0.0)
    here, there = (losses_on(device, file, config, two_scans(file)) for device in ("cpu", "cuda"))
    assert there == pytest.approx(here, rel=1e-3)
