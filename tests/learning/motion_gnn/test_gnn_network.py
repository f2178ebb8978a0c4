"""Network of the motion GNN: numbers of parameters, invariances and inputs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from small_shapes import cabinet

from kinmo.config import GnnConfig, load_config
from kinmo.learning.motion_gnn.gnn_batches import shape_graph, subsampled
from kinmo.learning.motion_gnn.gnn_network import MotionGnn, along_box, from_box
from kinmo.learning.motion_gnn.hierarchy_graph import ShapeGraph, batch_graphs

PAPER, SMALL = (load_config(name).gnn for name in ("paper", "small"))


def count(module: torch.nn.Module) -> int:
    return sum(p.numel() for p in module.parameters())


def linear(*widths: int) -> int:
    return sum(a * b + b for a, b in pairwise(widths))


def parameters_by_hand(buckets: int, inner_box: int) -> int:
    """Parameters of the release, layer by layer. Convolutions and the first linear layers of a DGCNN have no bias. A norm has
    two parameters a channel.
    """
    norms = 2 * (64 + 64 + 128 + 512 + 512 + 256)
    edge_convolutions = 6 * 64 + 128 * 64 + 128 * 128
    dgcnn = edge_convolutions + 256 * 512 + 1024 * 512 + 512 * 256 + linear(256, 100) + norms
    leaf = linear(15, 100) + linear(200, 256)
    names, relations = buckets * 256, (4 + 6) * 128
    children = linear(256 + 256, 256) + 2 * linear(256 + 256 + 256, 256) + linear(3 * 256 + inner_box, 256)
    graph_inputs = buckets * 128 + (4 + 6) * 128
    first = linear(384 + 256 + 384, 512, 512 + 128 + 512) + linear(512, 512, 128)
    later = linear(3 * 128, 512, 1152) + linear(512, 512, 128)
    return dgcnn + leaf + names + relations + children + graph_inputs + first + 4 * later + linear(128, 128, 128, 16)


def test_the_paper_network_has_as_many_parameters_as_the_release() -> None:
    assert count(MotionGnn(PAPER, 10)) == parameters_by_hand(PAPER.name_buckets, inner_box=0)


def test_boxes_of_inner_parts_widen_one_layer() -> None:
    assert count(MotionGnn(replace(PAPER, inner_boxes=True), 10)) == parameters_by_hand(PAPER.name_buckets, inner_box=100)
    assert count(MotionGnn(PAPER, 10)) - count(MotionGnn(PAPER, 5)) == 5 * 129


def graph(seed: int, config: GnnConfig = SMALL) -> ShapeGraph:
    return subsampled(shape_graph(cabinet(seed), config), 64)


def test_predictions_for_a_shape_do_not_depend_on_the_rest_of_the_batch() -> None:
    torch.manual_seed(0)
    network = MotionGnn(SMALL, 10).eval()
    graphs = [graph(seed) for seed in range(4)]
    together = network(batch_graphs(graphs))
    alone = [network(batch_graphs([g])) for g in graphs]
    for index, found in enumerate(together):
        torch.testing.assert_close(found, torch.cat([a[index] for a in alone]), atol=1e-4, rtol=1e-4)


def test_the_order_of_siblings_does_not_matter() -> None:
    torch.manual_seed(0)
    network = MotionGnn(SMALL, 10).eval()
    one = graph(3)
    order = torch.arange(len(one.parents)).flip(0)  # any numbering of the parts is valid
    place = torch.argsort(order)
    names = one.name_ids.split(one.name_counts.tolist())
    other = replace(
        one,
        leaf_points=one.leaf_points.flip(0),
        leaves=place[one.leaves].flip(0),
        parents=torch.where(one.parents < 0, -1, place[one.parents])[order],
        depths=one.depths[order],
        boxes=one.boxes[order],
        name_ids=torch.cat([names[i] for i in order.tolist()]),
        name_counts=one.name_counts[order],
        edges=place[one.edges],
    )
    for a, b in zip(network(batch_graphs([one])), network(batch_graphs([other])), strict=True):
        torch.testing.assert_close(a, b, atol=1e-4, rtol=1e-4)


def test_boxes_of_inner_parts_matter_only_if_configured() -> None:
    torch.manual_seed(0)
    with_boxes, without = (MotionGnn(replace(SMALL, inner_boxes=b), 10).encoder.eval() for b in (True, False))
    one = graph(3)
    inner = torch.ones(len(one.parents), dtype=torch.bool)
    inner[one.leaves] = False
    moved = replace(one, boxes=one.boxes + inner[:, None])
    for encoder, differs in ((with_boxes, True), (without, False)):
        same = torch.allclose(encoder(batch_graphs([one])), encoder(batch_graphs([moved])))
        assert same != differs


def test_an_unknown_word_is_treated_like_a_similar_known_word() -> None:
    torch.manual_seed(0)
    network = MotionGnn(SMALL, 10).eval()
    shape = cabinet(3)

    def logits(word: str) -> torch.Tensor:
        names = tuple(name.replace("handle", word) for name in shape.part_names)
        return network(batch_graphs([subsampled(shape_graph(replace(shape, part_names=names), SMALL), 64)])).logits

    known, similar, different = logits("handle"), logits("handlegrip"), logits("xylophone")
    assert torch.isfinite(different).all()
    assert (known - similar).norm() < (known - different).norm()


def test_pivots_are_in_half_extents_of_the_box_and_turn_with_it() -> None:
    boxes = torch.zeros(2, 15)
    boxes[:, :3] = torch.tensor([1.0, 2.0, 3.0])
    boxes[:, 3:6] = torch.tensor([2.0, 4.0, 0.0])
    boxes[0, 6:] = torch.eye(3).flatten()
    boxes[1, 6:] = torch.tensor([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]).flatten()
    found = from_box(torch.tensor([[1.0, -1.0, 0.0], [1.0, -1.0, 1.0]]), boxes)
    torch.testing.assert_close(found[0], torch.tensor([2.0, 0.0, 3.0]))
    torch.testing.assert_close(found[1, :2], torch.tensor([3.0, 3.0]))
    assert 0.0 < float(found[1, 2]) - 3.0 < 1.0  # a point off a thin plate


def test_directions_are_along_the_axes_of_the_moving_box() -> None:
    turned = Rotation.from_euler("xyz", [0.3, 0.2, -0.4]).as_matrix()
    boxes = torch.tensor(np.concatenate([[0.1, 0.2, 0.3, 1.0, 2.0, 3.0], turned.ravel()])[None], dtype=torch.float32)
    found = along_box(torch.tensor([[0.0, 3.0, 0.0]]), boxes)
    assert found.numpy() == pytest.approx(turned[1:2], abs=1e-6)
    assert along_box(torch.tensor([[1.0, -2.0, 0.5]]), boxes).norm().item() == pytest.approx(1.0)
