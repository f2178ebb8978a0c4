"""Training of the grouping networks, and prediction by them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch
from small_shapes import cabinet_shape

from kinmo.config import GroupingConfig, TrainingConfig
from kinmo.core.errors import InputError
from kinmo.core.shape_forms import flat_parts, flat_shape
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.grouping.grouping_batches import collate_graphs
from kinmo.methods.kinmo.grouping.grouping_network import mean_logits
from kinmo.methods.kinmo.grouping.grouping_training import train_part_grouping
from kinmo.methods.kinmo.grouping.leaf_graph import leaf_graph
from kinmo.methods.kinmo.grouping.merge_tree import merge_leaves
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper

CONFIG = GroupingConfig(
    TrainingConfig(epochs=12, learning_rate=8e-3, decay_epochs=0, keep="last", threads=1),
    members=2,
    width=16,
    rounds=2,
    batch_graphs=4,
)


@pytest.fixture(scope="module")
def shapes() -> list[PreparedShape]:
    return [prepare_shape(cabinet_shape(seed)[0]) for seed in range(8)]


@pytest.fixture(scope="module")
def weights(shapes: list[PreparedShape], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("grouping")
    train_part_grouping(shapes[:7], shapes[7:], CONFIG, folder, device="cpu")
    return folder / "weights.safetensors"


def test_drawers_and_their_handles_become_one_body_without_names_and_hierarchy(shapes, weights: Path) -> None:
    shape, grouper = shapes[7], PartGrouper.load(weights, "cpu")
    graph = leaf_graph(shape)
    assert graph is not None
    found = grouper.group(graph, hide_names=True, hide_hierarchy=True)
    merges = merge_leaves(len(shape.leaves), found.pairs, found.logits)
    candidates = {merge.leaves for merge in merges}
    mobility, _ = shape.annotation
    assert all(shape.body_leaves[body] in candidates for body, _ in mobility.movable())
    moving = {leaf for body, _ in mobility.movable() for leaf in shape.body_leaves[body]}
    assert [leaf in moving for leaf in range(len(shape.leaves))] == (found.moves > 0.5).tolist()


def test_the_order_of_parts_does_not_matter(weights: Path) -> None:
    grouper = PartGrouper.load(weights, "cpu")
    shape = cabinet_shape(7)[0]
    parts = flat_parts(shape)
    order = np.random.default_rng(0).permutation(len(parts)).tolist()
    logits = []
    for some in (list(range(len(parts))), order):
        graph = leaf_graph(prepare_shape(flat_shape(shape, [parts[i] for i in some])))
        assert graph is not None
        found = grouper.group(graph)
        named = [frozenset((some[a], some[b])) for a, b in found.pairs.tolist()]
        logits.append(dict(zip(named, found.logits, strict=True)))
    assert logits[0].keys() == logits[1].keys()
    assert all(abs(logits[0][pair] - logits[1][pair]) < 1e-3 for pair in logits[0])


def test_hidden_names_and_hierarchy_are_not_seen(shapes, weights: Path) -> None:
    graph = leaf_graph(shapes[0])
    assert graph is not None and graph.has_names and graph.has_hierarchy
    hidden = collate_graphs([graph], hide_names=1.0, hide_hierarchy=1.0)
    shown = collate_graphs([graph])
    assert len(hidden.words) == 0 < len(shown.words)
    assert torch.count_nonzero(hidden.contact[:, -8:]) == 0 < torch.count_nonzero(shown.contact[:, -8:])


def test_a_batch_gives_the_logits_of_single_graphs(shapes, weights: Path) -> None:
    networks = PartGrouper.load(weights, "cpu").networks
    graphs = [graph for shape in shapes[:3] if (graph := leaf_graph(shape)) is not None]
    with torch.inference_mode():
        together = mean_logits(networks, collate_graphs(graphs))[0]
        alone = torch.cat([mean_logits(networks, collate_graphs([graph]))[0] for graph in graphs])
    assert torch.allclose(together, alone, atol=1e-4)
    half = len(graphs[0].pairs) // 2
    assert torch.equal(alone[:half], alone[half : 2 * half])


def test_a_shape_of_one_part_has_no_graph() -> None:
    shape = cabinet_shape(0)[0]
    assert leaf_graph(prepare_shape(flat_shape(shape, flat_parts(shape)[:1]))) is None


def test_training_needs_a_shape_with_two_parts(shapes, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="at least two parts"):
        train_part_grouping([], shapes, CONFIG, tmp_path, device="cpu")


def test_weights_of_another_network_are_refused(weights: Path, tmp_path: Path) -> None:
    for name in ("weights.safetensors", "weights.json"):
        (tmp_path / name).write_bytes((weights.parent / name).read_bytes().replace(b"part_grouping", b"joint_ranking"))
    with pytest.raises(InputError, match="kind"):
        PartGrouper.load(tmp_path / "weights.safetensors", "cpu")
    means = [network.leaf_mean for network in PartGrouper.load(weights, "cpu").networks]
    assert all(torch.isfinite(mean).all() for mean in means)
