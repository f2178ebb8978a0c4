"""Graphs of shapes, their augmented variants, and batches."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import torch
from small_shapes import cabinet

from kinmo.config import load_config
from kinmo.features.prepared_shape import Boxes
from kinmo.learning.motion_gnn.gnn_batches import GraphData, shape_graph, transformed_graph
from kinmo.learning.motion_gnn.hierarchy_graph import ShapeGraph
from kinmo.learning.name_encoding import HIDDEN

CONFIG = load_config("small").gnn


def test_a_mirrored_graph_has_mirrored_boxes_and_pivots() -> None:
    shape = cabinet(4)
    plain = shape_graph(shape, CONFIG)
    mirrored = transformed_graph(plain, shape, CONFIG, np.diag([-1.0, 1.0, 1.0]))
    for name in ("states", "types"):
        assert torch.equal(getattr(plain, name), getattr(mirrored, name))
    flip = torch.tensor([-1.0, 1.0, 1.0])
    torch.testing.assert_close(mirrored.boxes[:, :3], plain.boxes[:, :3] * flip)
    torch.testing.assert_close(mirrored.boxes[:, 3:6], plain.boxes[:, 3:6])
    torch.testing.assert_close(mirrored.pivots, plain.pivots * flip)
    other_side = torch.tensor([1, 0, 2, 3, 4, 5])  # right is left
    distinct = (plain.boxes[plain.edges[:, 0], :3] - plain.boxes[plain.edges[:, 1], :3]).abs()[:, 0] > 0.02
    assert distinct.any()
    assert torch.equal(other_side[plain.sides][distinct], mirrored.sides[distinct])


def test_a_transformed_graph_equals_the_graph_of_the_transformed_shape() -> None:
    shape, change = cabinet(4), np.diag([-1.2, 0.8, 1.4])
    boxes, labels = shape.symmetric_boxes, shape.edge_labels
    assert np.allclose(np.abs(boxes.axes).max(axis=2), 1)  # axis-aligned boxes stay boxes under the map
    lengths = np.linalg.norm(boxes.axes @ change, axis=2)
    prepared = replace(
        shape,
        symmetric_boxes=Boxes(boxes.centers @ change, boxes.axes @ change / lengths[..., None], boxes.half_extents * lengths),
        edge_labels=replace(labels, directions=labels.directions @ change, pivots=labels.pivots @ change),
    )
    changed, expected = transformed_graph(shape_graph(shape, CONFIG), shape, CONFIG, change), shape_graph(prepared, CONFIG)
    for field in fields(ShapeGraph):
        torch.testing.assert_close(getattr(changed, field.name), getattr(expected, field.name))


def test_stretching_keeps_pivots_in_place_within_their_boxes() -> None:
    shape = cabinet(4)
    plain = shape_graph(shape, CONFIG)
    stretched = transformed_graph(plain, shape, CONFIG, np.diag([1.2, 0.9, 1.1]))
    turns = (plain.types >= 2) & (plain.types < 8)

    def places(graph: ShapeGraph) -> torch.Tensor:
        boxes = graph.boxes[graph.edges[:, 0]]
        local = torch.einsum("eij,ej->ei", boxes[:, 6:].view(-1, 3, 3), graph.pivots - boxes[:, :3])
        return (local / boxes[:, 3:6])[turns]

    assert turns.any()
    torch.testing.assert_close(places(plain), places(stretched), atol=1e-4, rtol=1e-4)


def test_a_true_direction_does_not_depend_on_the_sign_of_the_axis() -> None:
    shape = cabinet(4)
    labels = shape.edge_labels
    reversed_joints = replace(shape, edge_labels=replace(labels, directions=-labels.directions))
    assert torch.equal(shape_graph(shape, CONFIG).directions, shape_graph(reversed_joints, CONFIG).directions)


def test_leaf_points_of_variants_fit_their_boxes() -> None:
    shape = cabinet(4)
    data = GraphData([shape], [shape], replace(CONFIG, variants=3, stretch=0.3, hide_names=0.0))
    seen = [next(iter(data.training_batches(0, np.random.default_rng(seed)))).graph for seed in range(16)]
    places = {tuple(np.round(g.boxes[:, :3].flatten().numpy(), 3).tolist()) for g in seen}
    assert len(places) == 4
    for graph in seen:
        leaf = graph.leaf_points[0]
        axes = graph.boxes[graph.leaves[0], 6:].view(3, 3)
        spans = np.ptp((leaf @ axes.T).numpy(), axis=0)
        sizes = graph.boxes[graph.leaves[0], 3:6].numpy()
        np.testing.assert_allclose(spans / spans.max(), sizes / sizes.max(), atol=0.08)
        assert float(leaf.norm(dim=1).max()) <= 1.0 + 1e-6


def test_names_are_hidden_as_often_as_configured() -> None:
    data = GraphData([cabinet(i) for i in range(20)], [cabinet(0)], replace(CONFIG, hide_names=0.5, batch_shapes=1))
    hidden = [bool((b.graph.name_ids == HIDDEN).all()) for b in data.training_batches(0, np.random.default_rng(0))]
    assert 4 <= sum(hidden) <= 16


def test_batches_respect_the_limits_and_contain_every_shape_once() -> None:
    shapes = [cabinet(i) for i in range(12)]
    data = GraphData(shapes, shapes[:1], replace(CONFIG, batch_shapes=5, batch_edges=30))
    batches = list(data.training_batches(0, np.random.default_rng(0)))
    assert sum(len(b.edge_counts) for b in batches) == len(shapes)
    assert all(len(b.edge_counts) <= 5 and (sum(b.edge_counts) <= 30 or len(b.edge_counts) == 1) for b in batches)
