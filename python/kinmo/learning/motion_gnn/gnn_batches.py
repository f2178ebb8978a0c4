"""Prepared shapes as graphs of tensors, augmented variants of them, and batches."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import Boxes, PreparedShape
from kinmo.learning.motion_gnn.box_relations import box_sides, box_states, canonical_boxes, object_axes
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch, ShapeGraph, batch_graphs
from kinmo.learning.name_encoding import HIDDEN, encode_names

F64 = NDArray[np.float64]


def shape_graph(shape: PreparedShape, config: GnnConfig) -> ShapeGraph:
    """Graph of one shape, with all points of its leaves and the edges that `used_edges` gives.

    The sign of a joint's axis only tells which way its range runs. Therefore true directions point towards the object's right,
    up or front. A shape without labels has types of -1, and zero directions and pivots.
    """
    used = used_edges(shape, config)
    edges = shape.edges[used]
    name_ids, name_counts = encode_names(shape.part_names, config.name_buckets)
    return ShapeGraph(
        leaf_points=_unit_clouds(torch.from_numpy(np.array(shape.leaf_points, np.float32))),
        leaves=_integers(shape.leaves),
        parents=_integers(shape.parents),
        depths=_integers(_depths(shape.parents)),
        name_ids=_integers(name_ids),
        name_counts=_integers(name_counts),
        up=_floats(shape.up),
        edges=_integers(edges).reshape(-1, 2),
        states=_integers(box_states(shape.symmetric_boxes, edges)),
        types=_integers(np.full(len(edges), -1) if shape.edge_labels is None else shape.edge_labels.types[used]),
        **_geometry(shape, config, used, np.eye(3)),
    )


def transformed_graph(graph: ShapeGraph, shape: PreparedShape, config: GnnConfig, transform: F64) -> ShapeGraph:
    """The graph of a shape under a linear map [3, 3], except for the leaf points, which the caller transforms.

    The map must be nearly diagonal along the object's axes. Box states stay as they are: a linear map leaves shares of volumes
    unchanged.
    """
    return replace(graph, **_geometry(shape, config, used_edges(shape, config), transform))


def _geometry(shape: PreparedShape, config: GnnConfig, used: NDArray[np.int64], transform: F64) -> dict[str, Tensor]:
    """Fields of a graph that a linear map changes."""
    edges, labels = shape.edges[used], shape.edge_labels
    boxes = canonical_boxes(_transformed(shape.symmetric_boxes, transform), shape.up)
    zeros = np.zeros((len(edges), 3))
    return {
        "boxes": _floats(np.concatenate([boxes.centers, 2 * boxes.half_extents, boxes.axes.reshape(-1, 9)], axis=1)),
        "sides": _integers(box_sides(boxes, edges)),
        "directions": _floats(zeros if labels is None else _with_sign(labels.directions[used] @ transform.T, shape.up)),
        "pivots": _floats(zeros if labels is None else labels.pivots[used] @ transform.T),
    }


def used_edges(shape: PreparedShape, config: GnnConfig) -> NDArray[np.int64]:
    """Indices of the edges that the network sees: all sibling pairs, or only those in contact (`GnnConfig.edges`)."""
    if config.edges == "siblings":
        return np.arange(len(shape.edges))
    return np.flatnonzero(shape.edge_distances <= config.contact)


_Variant = tuple[ShapeGraph, Tensor | None]
"""Graph of a shape, and the linear map [3, 3] that its leaf points still need (None: no map)."""


class GraphData:
    """Batches of training and validation graphs.

    A batch has at most `batch_shapes` shapes and `batch_edges` edges. Training shapes are augmented: one of several variants
    is drawn, with random points, and names are hidden at random. Shapes without a used edge are skipped.
    """

    def __init__(self, training: Sequence[PreparedShape], validation: Sequence[PreparedShape], config: GnnConfig) -> None:
        self.config = config
        self.training = [_variants(shape, config) for shape in training if len(used_edges(shape, config))]
        graphs = (shape_graph(shape, config) for shape in validation if len(used_edges(shape, config)))
        sampled = [subsampled(graph, config.leaf.points) for graph in graphs]
        self._validation = [batch_graphs(group) for group in batch_groups(sampled, config)]

    @property
    def labels(self) -> Tensor:
        """Motion types of all training edges [E]."""
        return torch.cat([variants[0][0].types for variants in self.training])

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[GraphBatch]:
        """Every training shape once, in random order."""
        graphs = (self._drawn(self.training[i], rng) for i in rng.permutation(len(self.training)))
        return map(batch_graphs, batch_groups(graphs, self.config))

    def validation_batches(self) -> Sequence[GraphBatch]:
        """Every validation shape once, the same each time."""
        return self._validation

    def _drawn(self, variants: Sequence[_Variant], rng: np.random.Generator) -> ShapeGraph:
        variant, transform = variants[int(rng.integers(len(variants)))]
        graph = subsampled(variant, self.config.leaf.points, rng)
        if transform is not None:
            graph = replace(graph, leaf_points=_unit_clouds(graph.leaf_points @ transform.T))
        if rng.random() < self.config.hide_names:
            graph = without_names(graph)
        return graph


def _variants(shape: PreparedShape, config: GnnConfig) -> list[_Variant]:
    """The shape itself and `config.variants` transformed forms, the same ones each time."""
    original = shape_graph(shape, config)
    rng = np.random.default_rng(zlib.crc32(shape.id.encode()))
    transforms = [random_transform(shape.up, config.stretch, rng) for _ in range(config.variants)]
    return [(original, None), *((transformed_graph(original, shape, config, each), _floats(each)) for each in transforms)]


def random_transform(up: F64, stretch: float, rng: np.random.Generator) -> F64:
    """Random linear map [3, 3] that mirrors left to right in half of all cases and stretches along the object's axes.

    The logarithms of the stretch factors are in [-stretch, stretch].
    """
    axes = object_axes(up)
    factors = np.exp(rng.uniform(-stretch, stretch, 3))
    factors[0] *= rng.choice([-1.0, 1.0])
    return np.asarray(axes.T @ np.diag(factors) @ axes)


def batch_groups(graphs: Iterable[ShapeGraph], config: GnnConfig) -> Iterator[list[ShapeGraph]]:
    """Runs of at most `batch_shapes` graphs and `batch_edges` edges; a single graph may have more edges."""
    group: list[ShapeGraph] = []
    edges = 0
    for graph in graphs:
        if group and (len(group) == config.batch_shapes or edges + len(graph.edges) > config.batch_edges):
            yield group
            group, edges = [], 0
        group.append(graph)
        edges += len(graph.edges)
    if group:
        yield group


def subsampled(graph: ShapeGraph, points: int, rng: np.random.Generator | None = None) -> ShapeGraph:
    """Graph with at most `points` points a leaf: random ones, or without `rng` ones evenly spread over those stored."""
    stored = graph.leaf_points.shape[1]
    if stored <= points:
        return graph
    evenly = np.linspace(0, stored - 1, points).astype(np.int64)
    chosen = evenly if rng is None else rng.permutation(stored)[:points]
    return replace(graph, leaf_points=graph.leaf_points[:, torch.from_numpy(chosen)])


def without_names(graph: ShapeGraph) -> ShapeGraph:
    """The same graph with all names hidden."""
    counts = torch.ones_like(graph.name_counts)
    return replace(graph, name_ids=torch.full_like(counts, HIDDEN), name_counts=counts)


def _transformed(boxes: Boxes, transform: F64) -> Boxes:
    axes = boxes.axes @ transform.T
    lengths = np.linalg.norm(axes, axis=2)
    return Boxes(boxes.centers @ transform.T, axes / lengths[..., None], boxes.half_extents * lengths)


def _with_sign(directions: F64, up: F64) -> F64:
    """Unit vectors along `directions` [E, 3] (zero stays zero) whose largest component right, up or front is positive."""
    components = directions @ object_axes(up).T
    largest = np.take_along_axis(components, np.argmax(np.abs(components), axis=1)[:, None], axis=1)
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return np.asarray(directions / np.where(lengths > 0, lengths, 1.0) * np.where(largest < 0, -1.0, 1.0))


def _unit_clouds(points: Tensor) -> Tensor:
    """Clouds [L, n, 3], each centred on its mean and scaled into the unit sphere."""
    centered = points - points.mean(1, keepdim=True)
    radius = centered.norm(dim=2).amax(1).clamp(min=1e-9)
    return torch.div(centered, radius[:, None, None])


def _depths(parents: Sequence[int]) -> list[int]:
    depths: list[int] = []
    for parent in parents:  # in preorder, a parent comes before its children
        depths.append(0 if parent < 0 else depths[parent] + 1)
    return depths


def _integers(values: Sequence[int] | NDArray[np.int64]) -> Tensor:
    return torch.from_numpy(np.array(values, np.int64))


def _floats(values: F64) -> Tensor:
    return torch.from_numpy(np.array(values, np.float32))
