"""Part hierarchies of one or many shapes as one graph of tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class ShapeGraph:
    """Graph of one shape with N parts, L leaves and E edges from a moving to a reference part.

    Attributes:
        leaf_points: Points of the leaves [L, n, 3], each cloud centred and scaled into the unit sphere.
        leaves: Part of each leaf [L].
        parents: Parent of each part [N]; -1 for the root.
        depths: Depth of each part [N]; 0 for the root.
        boxes: Box of each part [N, 15]: centre (3), full size (3), axes (9).
        name_ids: Name buckets of all parts, one part after the other [T].
        name_counts: Number of name buckets of each part [N].
        up: Up direction [3].
        edges: Moving and reference part of each edge [E, 2].
        states: Overlap of the two boxes [E] (`box_relations.STATES`).
        sides: Side of the moving box [E] (`box_relations.SIDES`).
        types: True motion type of each edge [E]; -1 for a shape without labels.
        directions: True unit directions [E, 3].
        pivots: True pivots [E, 3].
    """

    leaf_points: Tensor
    leaves: Tensor
    parents: Tensor
    depths: Tensor
    boxes: Tensor
    name_ids: Tensor
    name_counts: Tensor
    up: Tensor
    edges: Tensor
    states: Tensor
    sides: Tensor
    types: Tensor
    directions: Tensor
    pivots: Tensor


@dataclass(frozen=True, eq=False)
class HierarchyLevel:
    """Parts of one depth (children) with their parents.

    Attributes:
        children: Parts of this depth [C].
        parents: Their parents, each once [P].
        slots: Parent of each child [C], as an index into `parents`.
        edges: Edges among the children [M], as indices into the graph's edges.
        starts: First end of each of these edges [M], as an index into `children`.
        ends: Second end of each of these edges [M], as an index into `children`.
    """

    children: Tensor
    parents: Tensor
    slots: Tensor
    edges: Tensor
    starts: Tensor
    ends: Tensor

    def to(self, device: torch.device | str) -> HierarchyLevel:
        """The same level on a device."""
        return HierarchyLevel(*(value.to(device) for value in vars(self).values()))


@dataclass(frozen=True, eq=False)
class GraphBatch:
    """Several shapes as one graph.

    Attributes:
        graph: Parts and edges of all shapes, numbered one shape after the other. `graph.up` is [B, 3].
        levels: Levels of all hierarchies together, the deepest first.
        edge_counts: Number of edges of each shape [B].
    """

    graph: ShapeGraph
    levels: tuple[HierarchyLevel, ...]
    edge_counts: tuple[int, ...]

    def to(self, device: torch.device | str) -> GraphBatch:
        """The same batch on a device."""
        graph = ShapeGraph(*(value.to(device) for value in vars(self.graph).values()))
        return GraphBatch(graph, tuple(level.to(device) for level in self.levels), self.edge_counts)


def batch_graphs(shapes: Sequence[ShapeGraph]) -> GraphBatch:
    """Combine the graphs of several shapes into one."""
    sizes = [len(shape.parents) for shape in shapes]
    firsts = [sum(sizes[:i]) for i in range(len(sizes))]

    def joined(name: str) -> Tensor:
        return torch.cat([getattr(shape, name) for shape in shapes])

    def renumbered(name: str) -> Tensor:
        return torch.cat([getattr(shape, name) + first for shape, first in zip(shapes, firsts, strict=True)])

    values = {f.name: joined(f.name) for f in fields(ShapeGraph) if f.name not in ("leaves", "parents", "edges", "up")}
    parents = torch.cat([torch.where(s.parents < 0, -1, s.parents + first) for s, first in zip(shapes, firsts, strict=True)])
    up = torch.stack([shape.up for shape in shapes])
    graph = ShapeGraph(leaves=renumbered("leaves"), edges=renumbered("edges"), parents=parents, up=up, **values)
    return GraphBatch(graph, _levels(graph), tuple(len(shape.edges) for shape in shapes))


def _levels(graph: ShapeGraph) -> tuple[HierarchyLevel, ...]:
    edge_depths = graph.depths[graph.edges[:, 0]]
    place = torch.zeros_like(graph.parents)
    levels = []
    for depth in range(int(graph.depths.max()), 0, -1):
        children = torch.nonzero(graph.depths == depth).squeeze(1)
        place[children] = torch.arange(len(children))
        parents, slots = torch.unique(graph.parents[children], return_inverse=True)
        edges = torch.nonzero(edge_depths == depth).squeeze(1)
        starts, ends = place[graph.edges[edges]].unbind(1)
        levels.append(HierarchyLevel(children, parents, slots, edges, starts, ends))
    return tuple(levels)
