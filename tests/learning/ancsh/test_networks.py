"""The networks of ANCSH: their sizes, their losses, and that they learn."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
import pytest
import torch

from kinmo.config import AncshConfig, AncshNetworkName, MeanOver, Precision, ScansConfig, TrainingConfig, load_config
from kinmo.errors import InputError
from kinmo.learning.ancsh import point_sets
from kinmo.learning.ancsh.data import ScanData, least_trusted
from kinmo.learning.ancsh.loss import ScanBatch, joint_losses, part_losses, relaxed_iou_loss, total
from kinmo.learning.ancsh.network import (
    KIND,
    AncshNetwork,
    JointAnswers,
    LayoutAnswers,
    LayoutHead,
    PartAnswers,
    PartMaps,
    PartNetwork,
)
from kinmo.learning.ancsh.point_sets import Level, levels_of
from kinmo.learning.ancsh.predict import Ancsh, to_naocs
from kinmo.learning.ancsh.targets import layout
from kinmo.learning.ancsh.train import AncshLearner, train_ancsh
from kinmo.learning.weights import save_weights
from kinmo.scans.input_frame import InputFrame, base_axes, scan_rotations
from kinmo.scans.scan import scan
from kinmo.scans.scan_file import Provenance, Role, ScanFile, open_scans, write_scans
from kinmo.scans.typical import Typical
from kinmo.typed_tables import to_table
from scanned import cupboard_object

TINY = AncshConfig(
    training=TrainingConfig(epochs=2, learning_rate=3e-3, weight_decay=0.0, decay_epochs=0, threads=1),
    points=128,
    centers=(32, 16),
    neighbours=(8, 8),
    width=0.125,
    dropout=0.0,
    batch_frames=8,
    batches_per_epoch=3,
)
UNUSED = {"confidence.weight", "confidence.bias"}
"""Parameters of the release that no loss trains."""

SCAN_ALONE = replace(TINY, normalised="scan", axes="camera")


def shared(*widths: int) -> int:
    """Parameters of layers without a bias, each with a batch norm."""
    return sum(before * after + 2 * after for before, after in pairwise(widths))


def linear(before: int, after: int) -> int:
    return before * after + after


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> ScanFile:
    target = cupboard_object()
    path = tmp_path_factory.mktemp("scans") / "cupboard.safetensors"
    write_scans(path, target, scan(target, ScansConfig(states=6, views=4, size=128, points=256), 0), Provenance())
    return open_scans(path)


@pytest.mark.parametrize("parts", [2, 3, 5])
def test_the_paper_networks_have_as_many_parameters_as_the_printed_sizes_say(parts: int) -> None:
    backbone = shared(3, 64, 64, 128) + shared(3 + 128, 128, 128, 256) + shared(3 + 256, 256, 512, 1024)
    backbone += shared(1024 + 256, 256, 256) + shared(256 + 128, 256, 128) + shared(128 + 3, 128, 128, 128)
    backbone += shared(128, 128)
    own = linear(128, parts) + linear(128, 128) + linear(128, 3 * parts)
    joints = linear(128, parts) + linear(128, 3 * parts) + shared(128, 128, 128)
    joints += linear(128, 3) + linear(128, 3) + linear(128, 1) + linear(128, parts)
    joints += linear(128, 1)  # the confidence, which nothing uses
    config = load_config("paper").ancsh
    count = [sum(p.numel() for p in kind(config, parts, parts).parameters()) for kind in (PartNetwork, AncshNetwork)]
    assert count == [backbone + own, backbone + own + joints]


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


def two_scans(file: ScanFile) -> ScanBatch:
    return ScanData([file], [file], TINY).batch([(file, 0), (file, 3)], np.random.default_rng(0))


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


def test_a_layout_has_boxes_of_diagonal_one_and_the_pivots_next_to_the_parts_that_move(file: ScanFile) -> None:
    half_sizes, pivots, is_line = layout(file.extents, file.joints)
    np.testing.assert_allclose(np.linalg.norm(half_sizes, axis=1), 0.5, atol=1e-3)
    assert is_line.tolist() == [joint.has_pivot for joint in file.joints]
    for joint, pivot, middle in zip(file.joints, pivots - 0.5, file.extents.centers[1:], strict=True):
        np.testing.assert_allclose(np.cross(pivot - joint.pivot, joint.direction), 0.0, atol=1e-6)
        assert (middle - pivot) @ joint.direction == pytest.approx(0.0, abs=1e-6)


def test_nothing_learnt_all_scans_have_the_same_layout() -> None:
    found = LayoutHead(16, 3)(torch.rand(4, 1, 16))
    torch.testing.assert_close(found.half_sizes, torch.full((4, 3, 3), 0.5 / 3**0.5))
    torch.testing.assert_close(found.pivots, torch.full((4, 2, 3), 0.5))


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


def test_training_makes_the_loss_smaller_and_what_is_written_answers_scans(file: ScanFile, tmp_path: Path) -> None:
    config = replace(TINY, training=replace(TINY.training, epochs=8, learning_rate=1e-2), batches_per_epoch=8)
    for which in ("ancsh", "npcs"):
        result = train_ancsh([file], [file], config, tmp_path / which, which=which, device="cpu")
        assert result.best_error < 0.95 * result.history[0]["validation/error"]
    networks = Ancsh.load(tmp_path / "ancsh" / "weights.safetensors", tmp_path / "npcs" / "weights.safetensors", "cpu")
    assert networks.structure == file.structure
    assert networks.typical.to_data() == Typical.of([file]).to_data()
    answers, found = networks.find(list(file.read("points", slice(0, 3))))
    assert len(found) == 3
    assert all(len(said.parts) == 256 and said.npcs.shape == (256, 3) for said in answers)
    again = networks.answer(list(file.read("points", slice(0, 3))))
    np.testing.assert_array_equal(answers[0].npcs, again[0].npcs)


@pytest.mark.parametrize("which", ["ancsh", "npcs"])
def test_training_in_mixed_precision_comes_to_the_same(file: ScanFile, tmp_path: Path, which: AncshNetworkName) -> None:
    precisions: tuple[Precision, ...] = ("32-true", "bf16-mixed")
    errors = [
        train_ancsh(
            [file],
            [file],
            replace(TINY, training=replace(TINY.training, precision=precision)),
            tmp_path / precision,
            which=which,
            device="cpu",
        ).best_error
        for precision in precisions
    ]
    assert errors[0] != errors[1] == pytest.approx(errors[0], rel=0.05)


def test_how_large_a_scan_is_does_not_matter(file: ScanFile) -> None:
    torch.manual_seed(0)
    parts = file.structure.part_count
    network = AncshNetwork(TINY, parts, parts).eval()
    networks = Ancsh(network, network, TINY, file.structure, Typical.unknown(file.structure), "cpu")
    points = file.read("points", 0).astype(np.float64)
    here, there = (networks.answer([cloud])[0] for cloud in (points, 1e5 * points))
    np.testing.assert_allclose(here.npcs, there.npcs, atol=5e-3)
    np.testing.assert_allclose(here.frame.rotation, there.frame.rotation, atol=1e-3)


def test_what_takes_parts_to_the_object_is_read_off_the_points_whatever_single_points_say() -> None:
    rng = np.random.default_rng(0)
    npcs, scales, shifts = rng.uniform(0.1, 0.9, (90, 3, 3)), np.array([0.9, 0.5, 0.2]), rng.uniform(-0.3, 0.5, (3, 3))
    parts = np.repeat([0, 1], 45)  # of the last part no point was seen
    naocs = scales[:, None] * npcs + shifts
    found = to_naocs(npcs, naocs, parts)
    np.testing.assert_allclose(found[0], scales, rtol=1e-9)
    np.testing.assert_allclose(found[1], shifts, atol=1e-9)


def test_where_a_scan_lies_does_not_matter_to_networks_that_see_the_scan_alone(file: ScanFile) -> None:
    torch.manual_seed(0)
    parts = file.structure.part_count
    network = AncshNetwork(SCAN_ALONE, parts, parts)
    known = Typical.unknown(file.structure)
    networks = Ancsh(network.eval(), network, SCAN_ALONE, file.structure, known, "cpu")
    points = file.read("points", 0).astype(np.float64)
    here, there = (networks.answer([cloud])[0] for cloud in (points, 2.5 * points + [1.0, 2.0, -3.0]))
    np.testing.assert_allclose(here.npcs, there.npcs, atol=1e-4)


def test_the_paper_networks_take_a_step(file: ScanFile) -> None:
    config = replace(load_config("paper").ancsh, batch_frames=2)
    batch = ScanData([file], [file], config).batch([(file, 0), (file, 1)], np.random.default_rng(0))
    network = AncshNetwork(config, file.structure.part_count, file.structure.part_count)
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-3)
    before = {name: p.detach().clone() for name, p in network.named_parameters()}
    for _ in range(2):
        parts, joints = network.forward_all(batch.points)
        losses = part_losses(parts, batch, config.mean_over) | joint_losses(parts, joints, batch, config.mean_over)
        loss = total(losses, config)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    assert torch.isfinite(loss)
    still = {name for name, parameters in network.named_parameters() if torch.equal(before[name], parameters)}
    assert still == UNUSED


def test_the_paper_networks_drop_after_each_layer_that_only_joints_have() -> None:
    layers = AncshNetwork(load_config("paper").ancsh, 3, 3).near_joints
    assert [layer.p for layer in layers if isinstance(layer, torch.nn.Dropout)] == [0.5, 0.5]
    assert isinstance(layers[-1], torch.nn.Dropout)


@pytest.mark.parametrize(("norms", "momenta"), [("release", [0.5, 0.25, 0.01]), ("steady", [0.1, 0.1, 0.1])])
def test_norms_move_slower_as_the_rate_falls_in_the_release(
    norms: Literal["steady", "release"], momenta: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    config = replace(TINY, norms=norms, training=replace(TINY.training, decay_epochs=10))
    learner = AncshLearner(config, "npcs", 2, 2)
    for epoch, momentum in zip((9, 10, 100), momenta, strict=True):
        monkeypatch.setattr(AncshLearner, "current_epoch", epoch)
        learner.on_train_epoch_start()
        found = {layer.momentum for layer in learner.modules() if isinstance(layer, torch.nn.BatchNorm1d)}
        assert found == {momentum}


def losses_on(device: str, file: ScanFile, config: AncshConfig, batch: ScanBatch) -> dict[str, float | None]:
    """Of new networks, forward and backward; None where tensors have no values."""
    torch.manual_seed(0)
    parts = file.structure.part_count
    found: dict[str, torch.Tensor] = {}
    for kind in (PartNetwork, AncshNetwork):
        network, seen = kind(config, parts, parts).to(device), batch.to(device)
        if isinstance(network, AncshNetwork):
            said, joints = network.forward_all(seen.points)
            found |= part_losses(said, seen, config.mean_over) | joint_losses(said, joints, seen, config.mean_over)
            total(found, config).backward()
        else:
            found |= part_losses(network(seen.points), seen, config.mean_over)
            total(found, config).backward()
        gradients = [own.grad for name, own in network.named_parameters() if name not in UNUSED]
        assert all(each is not None and each.device.type == device for each in gradients)
    assert all(loss.device.type == device for loss in found.values())
    return {name: None if device == "meta" else loss.item() for name, loss in found.items()}


@pytest.mark.parametrize("name", ["small", "paper"])
def test_networks_and_losses_are_worked_out_where_their_tensors_are(
    file: ScanFile, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the device `meta`, which has no values, so that whatever were made on the CPU would not fit."""

    def levels_there(points: torch.Tensor, *grouping: Any) -> tuple[Level, ...]:
        levels = levels_of(torch.rand(points.shape), *grouping)  # of some points, as those on `meta` have no places
        return tuple(Level(*(each.to(points.device) for each in vars(level).values())) for level in levels)

    monkeypatch.setattr(point_sets, "levels_of", levels_there)
    losses_on("meta", file, load_config(name).ancsh, two_scans(file))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="there is no CUDA device here")
@pytest.mark.parametrize("name", ["small", "paper"])
def test_a_gpu_comes_to_the_same_losses(file: ScanFile, name: str) -> None:
    config = replace(load_config(name).ancsh, dropout=0.0)
    here, there = (losses_on(device, file, config, two_scans(file)) for device in ("cpu", "cuda"))
    assert there == pytest.approx(here, rel=1e-3)


def test_objects_of_two_structures_are_not_trained_together(file: ScanFile) -> None:
    other = replace(file, structure=replace(file.structure, parents=(0, 1, 0)))
    with pytest.raises(InputError, match="expected 4 parts"):
        train_ancsh([file, other], [file], TINY, Path("nowhere"), which="ancsh")
    with pytest.raises(InputError, match="at least one object"):
        train_ancsh([], [], TINY, Path("nowhere"), which="ancsh")


def test_a_part_map_is_linear_the_same_for_all_points_and_nothing_before_it_has_learnt() -> None:
    torch.manual_seed(0)
    maps = PartMaps(16, 3)
    points, whole = torch.rand(2, 50, 3), torch.rand(2, 1, 16)
    assert (maps(points, whole) == 0.0).all()
    torch.nn.init.normal_(maps.layers[-1].weight)
    found, middles = maps(points, whole), maps(points.mean(1, keepdim=True), whole)
    assert found.shape == (2, 50, 3, 3)
    torch.testing.assert_close(found.mean(1, keepdim=True), middles, rtol=1e-4, atol=1e-5)
    assert not torch.allclose(found[:, :, 0], found[:, :, 1])


@pytest.mark.parametrize(("beside", "least"), [("pseudo", 0.2), ("hidden", 0.2), ("unlabelled", 0.5)])
def test_what_networks_labelled_themselves_is_trusted_less(file: ScanFile, beside: Role, least: float) -> None:
    other = replace(file, provenance=replace(file.provenance, role=beside))
    assert least_trusted([file, other], replace(TINY, trusted=0.2, trusted_in_semi=0.5)) == least


def turned_apart(file: ScanFile) -> int:
    """A frame whose axes are others when it is known what is base."""
    points, parts = file.read("points"), file.read("parts")
    first = scan_rotations(points, "base")
    second = np.stack([base_axes(*each) for each in zip(points, parts == 0, first, strict=True)])
    return int(np.abs(second - first).max(axis=(1, 2)).argmax())


@pytest.mark.parametrize("points", [32, 128, 256])
def test_few_points_of_a_scan_are_seen_where_and_as_large_as_all_of_them_are(file: ScanFile, points: int) -> None:
    config = replace(SCAN_ALONE, points=points)
    batch = ScanData([file], [file], config).batch([(file, row) for row in range(8)], np.random.default_rng(0))
    for row in range(8):
        whole = file.read("points", row)
        seen = InputFrame.of(whole, "scan").apply(whole)
        each = np.abs(batch.points[row].numpy()[:, None] - seen[None]).max(axis=-1).min(axis=1)
        np.testing.assert_allclose(each, 0.0, atol=1e-6)


def test_half_of_the_scans_to_train_on_are_seen_along_the_axes_of_the_base(file: ScanFile) -> None:
    row = turned_apart(file)
    data = ScanData([file], [file], replace(TINY, axes="base", points=256))
    rng = np.random.default_rng(0)
    seen = [data.batch([(file, row)], rng).points[0].sort(dim=0).values for _ in range(40)]
    likeness = np.array([torch.allclose(cloud, seen[0], atol=1e-5) for cloud in seen])
    assert 0.25 < likeness.mean() < 0.75
    others = [cloud for cloud, alike in zip(seen, likeness, strict=True) if not alike]
    assert all(torch.allclose(cloud, others[0], atol=1e-5) for cloud in others)


def test_networks_that_look_once_see_scans_along_the_axes_of_all_that_is_seen(file: ScanFile) -> None:
    row = turned_apart(file)
    config = replace(SCAN_ALONE, axes="manhattan", points=len(file.read("points", row)))
    batch = ScanData([file], [file], config).batch([(file, row)], np.random.default_rng(0))
    whole = file.read("points", row)
    (first,) = scan_rotations(whole[None], "manhattan")
    seen = InputFrame.of(whole, "scan", rotation=first).apply(whole)
    np.testing.assert_allclose(np.sort(batch.points[0].numpy(), axis=0), np.sort(seen, axis=0), atol=1e-5)


def test_networks_look_again_along_the_axes_of_what_they_say_is_base(file: ScanFile, monkeypatch: pytest.MonkeyPatch) -> None:
    row, count = turned_apart(file), file.structure.part_count
    network = AncshNetwork(TINY, count, count).eval()
    points, parts = file.read("points", row), file.read("parts", row)
    monkeypatch.setattr(Ancsh, "_said_parts", lambda self, seen: np.tile(parts, (len(seen), 1)))
    rotations = {}
    for axes in ("manhattan", "base"):
        networks = Ancsh(network, network, replace(TINY, axes=axes), file.structure, Typical.unknown(file.structure), "cpu")
        rotations[axes] = networks.answer([points])[0].frame.rotation
    (first,) = scan_rotations(points[None], "manhattan")
    np.testing.assert_allclose(rotations["manhattan"], first)
    np.testing.assert_allclose(rotations["base"], base_axes(points, parts == 0, first))
    assert np.abs(rotations["base"] - first).max() > 0.1


def test_no_scans_have_no_answers(file: ScanFile) -> None:
    count = file.structure.part_count
    network = AncshNetwork(TINY, count, count).eval()
    assert Ancsh(network, network, TINY, file.structure, Typical.unknown(file.structure), "cpu").answer([]) == []


@pytest.mark.parametrize("classes", [None, "two", 0, 10**9])
def test_weights_that_do_not_say_how_many_classes_they_tell_apart_are_refused_in_one_line(
    file: ScanFile, tmp_path: Path, classes: object
) -> None:
    count, structure = file.structure.part_count, file.structure
    facts = {"kinds": [kind.value for kind in structure.kinds], "parents": list(structure.parents)}
    facts["typical"] = Typical.unknown(structure).to_data()
    whole, broken = tmp_path / "whole.safetensors", tmp_path / "broken.safetensors"
    network = AncshNetwork(TINY, count, count)
    save_weights(whole, network, KIND, to_table(TINY), facts | {"classes": count})
    save_weights(broken, network, KIND, to_table(TINY), facts if classes is None else facts | {"classes": classes})
    for paths in ((broken, None), (whole, broken)):
        with pytest.raises(InputError, match=rf"broken\.json: facts\.classes: expected {count} or {count + 1}, got"):
            Ancsh.load(*paths, "cpu")
    Ancsh.load(whole, None, "cpu")
