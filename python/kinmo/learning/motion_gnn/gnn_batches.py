"""Prepared shapes as graphs of tensors, and batches of them."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kinmo.config import GnnConfig
from kinmo.features.prepared_shape import Boxes, PreparedShape
from kinmo.learning.motion_gnn.box_relations import box_sides, box_states, canonical, object_axes, relative_poses
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch, ShapeGraph, batch_graphs
from kinmo.learning.name_encoding import HIDDEN, bags

F64 = NDArray[np.float64]

NEAR = 0.02
"""Distances are shown to the network as exp(-distance / NEAR)."""


def shape_graph(shape: PreparedShape, config: GnnConfig) -> ShapeGraph:
    """The tensors of one shape, with all points of its leaves and only the edges that `config.edges` wants (`used_edges`).

    A true direction has one sense, towards the object's right, up or front: the file's tells only which way the range runs.
    """
    used = used_edges(shape, config)
    edges = shape.edges[used]
    name_ids, name_counts = bags(shape.part_names, config.name_buckets)
    count = len(edges)
    return ShapeGraph(
        leaf_points=_unit_clouds(torch.from_numpy(np.array(shape.leaf_points, np.float32))),
        leaves=_whole(shape.leaves),
        parents=_whole(shape.parents),
        depths=_whole(_depths(shape.parents)),
        name_ids=_whole(name_ids),
        name_counts=_whole(name_counts),
        up=_real(shape.up),
        edges=_whole(edges).reshape(-1, 2),
        states=_whole(box_states(shape.symmetric_boxes, edges)),
        types=_whole(np.full(count, -1) if shape.edge_labels is None else shape.edge_labels.types[used]),
        **_measures(shape, config, used, np.eye(3)),
    )


def changed_graph(graph: ShapeGraph, shape: PreparedShape, config: GnnConfig, change: F64) -> ShapeGraph:
    """`graph`, that of `shape`, as if the shape had been prepared under `change` [3, 3], a linear map.

    The map should be nearly diagonal along the object's axes. Points are left to the caller. States stay, since linear maps
    leave shares of volumes as they are, and so do distances.
    """
    return replace(graph, **_measures(shape, config, used_edges(shape, config), change))


def _measures(shape: PreparedShape, config: GnnConfig, used: NDArray[np.int64], change: F64) -> dict[str, Tensor]:
    """What of a graph a linear map changes."""
    edges, labels = shape.edges[used], shape.edge_labels
    boxes = canonical(_changed(shape.symmetric_boxes, change), shape.up)
    distances = shape.edge_distances[used]
    relation = np.stack([np.exp(-distances / NEAR), distances <= config.contact], axis=1)
    still = np.zeros((len(edges), 3))
    return {
        "boxes": _real(np.concatenate([boxes.centers, 2 * boxes.half_extents, boxes.axes.reshape(-1, 9)], axis=1)),
        "sides": _whole(box_sides(boxes, edges)),
        "pose": _real(np.concatenate([relative_poses(boxes, edges), relation], axis=1)),
        "directions": _real(still if labels is None else _one_sense(labels.directions[used] @ change.T, shape.up)),
        "pivots": _real(still if labels is None else labels.pivots[used] @ change.T),
    }


def used_edges(shape: PreparedShape, config: GnnConfig) -> NDArray[np.int64]:
    """Indices of the edges that the network sees: all of them, or those of parts in contact."""
    if config.edges == "siblings":
        return np.arange(len(shape.edges))
    return np.flatnonzero(shape.edge_distances <= config.contact)


@dataclass(frozen=True, eq=False)
class _Variant:
    graph: ShapeGraph
    change: Tensor | None


class GraphData:
    """Training and validation graphs, batched so that no batch has many more than `batch_edges` edges."""

    def __init__(self, training: Sequence[PreparedShape], validation: Sequence[PreparedShape], config: GnnConfig) -> None:
        self.config = config
        self.training = [_variants(shape, config) for shape in training if len(used_edges(shape, config))]
        graphs = [shape_graph(shape, config) for shape in validation if len(used_edges(shape, config))]
        self._validation = [batch_graphs(group) for group in grouped((thinned(g, config.leaf.points) for g in graphs), config)]

    @property
    def labels(self) -> Tensor:
        """Types [E] of all training edges."""
        return torch.cat([variants[0].graph.types for variants in self.training])

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[GraphBatch]:
        order = (self._drawn(self.training[i], rng) for i in rng.permutation(len(self.training)))
        return map(batch_graphs, grouped(order, self.config))

    def validation_batches(self) -> Sequence[GraphBatch]:
        return self._validation

    def _drawn(self, variants: Sequence[_Variant], rng: np.random.Generator) -> ShapeGraph:
        variant = variants[int(rng.integers(len(variants)))]
        graph = thinned(variant.graph, self.config.leaf.points, rng)
        if variant.change is not None:
            graph = replace(graph, leaf_points=_unit_clouds(graph.leaf_points @ variant.change.T))
        if rng.random() < self.config.hide_names:
            graph = without_names(graph)
        return graph


def _variants(shape: PreparedShape, config: GnnConfig) -> list[_Variant]:
    first = _Variant(shape_graph(shape, config), None)
    rng = np.random.default_rng(zlib.crc32(shape.id.encode()))
    found = [first]
    for _ in range(config.variants):
        change = random_change(shape.up, config.stretch, rng)
        found.append(_Variant(changed_graph(first.graph, shape, config, change), _real(change)))
    return found


def random_change(up: F64, stretch: float, rng: np.random.Generator) -> F64:
    """A map [3, 3] that mirrors left to right every other time, and stretches each of the object's axes by e ** +-`stretch`."""
    axes = object_axes(up)
    factors = np.exp(rng.uniform(-stretch, stretch, 3))
    factors[0] *= rng.choice([-1.0, 1.0])
    change: F64 = axes.T @ np.diag(factors) @ axes
    return change


def grouped(graphs: Iterable[ShapeGraph], config: GnnConfig) -> Iterator[list[ShapeGraph]]:
    """Runs of at most `batch_shapes` graphs and `batch_edges` edges (more only for one shape that has more)."""
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


def thinned(graph: ShapeGraph, points: int, rng: np.random.Generator | None = None) -> ShapeGraph:
    """The graph with `points` points a leaf: drawn anew with `rng`, evenly spread over the stored ones without."""
    stored = graph.leaf_points.shape[1]
    if stored <= points:
        return graph
    evenly = np.linspace(0, stored - 1, points).astype(np.int64)
    chosen = evenly if rng is None else rng.permutation(stored)[:points]
    return replace(graph, leaf_points=graph.leaf_points[:, torch.from_numpy(chosen)])


def without_names(graph: ShapeGraph) -> ShapeGraph:
    """The graph with all names hidden."""
    counts = torch.ones_like(graph.name_counts)
    return replace(graph, name_ids=torch.full_like(counts, HIDDEN), name_counts=counts)


def _changed(boxes: Boxes, change: F64) -> Boxes:
    axes = boxes.axes @ change.T
    lengths = np.linalg.norm(axes, axis=2)
    return Boxes(boxes.centers @ change.T, axes / lengths[..., None], boxes.half_extents * lengths)


def _one_sense(directions: F64, up: F64) -> F64:
    """Unit vectors [E, 3] along `directions` (zero stays zero), the largest of their parts right, up and front positive."""
    parts = directions @ object_axes(up).T
    largest = np.take_along_axis(parts, np.argmax(np.abs(parts), axis=1)[:, None], axis=1)
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    unit: F64 = directions / np.where(lengths > 0, lengths, 1.0) * np.where(largest < 0, -1.0, 1.0)
    return unit


def _unit_clouds(points: Tensor) -> Tensor:
    centered = points - points.mean(1, keepdim=True)
    radius = centered.norm(dim=2).amax(1).clamp(min=1e-9)
    scaled: Tensor = centered / radius[:, None, None]
    return scaled


def _depths(parents: Sequence[int]) -> list[int]:
    depths: list[int] = []
    for parent in parents:  # preorder: a parent stands before its children
        depths.append(0 if parent < 0 else depths[parent] + 1)
    return depths


def _whole(values: Sequence[int] | NDArray[np.int64]) -> Tensor:
    return torch.from_numpy(np.array(values, np.int64))


def _real(values: F64) -> Tensor:
    return torch.from_numpy(np.array(values, np.float32))
