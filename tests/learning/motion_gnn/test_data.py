from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from kinmo.config import load_config
from kinmo.learning.motion_gnn.data import GraphData, rotation_about, shape_graph
from kinmo.learning.names import HIDDEN
from small_shapes import UP, cabinet

CONFIG = load_config("small").gnn


def test_a_rotation_turns_by_its_angle_about_its_axis() -> None:
    axis = np.array([0.6, 0.0, 0.8])
    rotation = rotation_about(axis, 0.7)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation @ axis, axis, atol=1e-12)
    np.testing.assert_allclose(np.trace(rotation), 1 + 2 * np.cos(0.7))
    np.testing.assert_allclose(rotation_about(np.array([0.0, 0, 1]), np.pi / 2) @ [1, 0, 0], [0, 1, 0], atol=1e-12)


def test_a_turned_graph_keeps_all_that_does_not_turn() -> None:
    shape = cabinet(4)
    plain, turned = shape_graph(shape, CONFIG), shape_graph(shape, CONFIG, rotation_about(UP, 0.4))
    for name in ("states", "sides", "types", "pose"):
        torch.testing.assert_close(getattr(plain, name), getattr(turned, name), atol=1e-5, rtol=1e-5)
    moving = plain.edges[:, 0]
    arms = [torch.linalg.norm(g.pivots - g.boxes[moving, :3], dim=1)[plain.types < 8] for g in (plain, turned)]
    torch.testing.assert_close(*arms, atol=1e-5, rtol=1e-5)
    assert not torch.allclose(plain.boxes, turned.boxes)


def test_turned_copies_are_shown_with_turned_points() -> None:
    shape = cabinet(4)
    data = GraphData([shape], [shape], replace(CONFIG, turns=3, hide_names=0.0))
    seen = [next(iter(data.training_batches(0, np.random.default_rng(seed)))).graph for seed in range(12)]
    places = {tuple(np.round(g.boxes[:, :3].flatten().numpy(), 3).tolist()) for g in seen}
    assert len(places) == 4
    for graph in seen:  # a cloud is as wide as its box along the box's first axis, however it is turned
        leaf = graph.leaf_points[0]
        axes = graph.boxes[graph.leaves[0], 6:].view(3, 3)
        spans = np.ptp((leaf @ axes.T).numpy(), axis=0)
        sizes = graph.boxes[graph.leaves[0], 3:6].numpy()
        np.testing.assert_allclose(spans / spans.max(), sizes / sizes.max(), atol=0.08)


def test_names_are_hidden_as_often_as_asked() -> None:
    data = GraphData([cabinet(i) for i in range(20)], [cabinet(0)], replace(CONFIG, hide_names=0.5, batch_shapes=1))
    hidden = [bool((b.graph.name_ids == HIDDEN).all()) for b in data.training_batches(0, np.random.default_rng(0))]
    assert 4 <= sum(hidden) <= 16


def test_batches_hold_few_enough_edges_and_every_shape_once() -> None:
    shapes = [cabinet(i) for i in range(12)]
    data = GraphData(shapes, shapes[:1], replace(CONFIG, batch_shapes=5, batch_edges=30))
    batches = list(data.training_batches(0, np.random.default_rng(0)))
    assert sum(len(b.edge_counts) for b in batches) == len(shapes)
    assert all(len(b.edge_counts) <= 5 and (sum(b.edge_counts) <= 30 or len(b.edge_counts) == 1) for b in batches)
