"""Hierarchies of many shapes as one graph of tensors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class ShapeGraph:
    """One shape. N parts, L leaves, E edges (moving, reference), all indices into the parts.

    `leaf_points` [L, n, 3] each centred in the unit sphere, `boxes` [N, 15] (centre, full size, axes), `name_ids` [T] the name
    buckets of all parts one after the other, `name_counts` [N], `up` [3]. Edges have a `state` and a `side` [E] and `pose` [E,
    F]. `types` [E], `directions` and `pivots` [E, 3] are the truth; a shape without one has -1 as types.
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
    pose: Tensor
    types: Tensor
    directions: Tensor
    pivots: Tensor


@dataclass(frozen=True, eq=False)
class Level:
    """The parts of one depth (`children`) and the depth above (`parents`), as indices of nodes.

    `slots` [C] is each child's parent as a place in `parents`; `edges` [M] are the edges among the children, as indices of
    edges, and `starts` and `ends` [M] their ends as places in `children`.
    """

    children: Tensor
    parents: Tensor
    slots: Tensor
    edges: Tensor
    starts: Tensor
    ends: Tensor

    def to(self, device: torch.device | str) -> Level:
        return Level(*(getattr(self, f.name).to(device) for f in fields(self)))


@dataclass(frozen=True, eq=False)
class GraphBatch:
    """Several shapes side by side: nodes and edges numbered on, levels deepest first, `edge_counts` [B] the edges of each
    shape.
    """

    graph: ShapeGraph
    levels: tuple[Level, ...]
    edge_counts: tuple[int, ...]

    def to(self, device: torch.device | str, non_blocking: bool = False) -> GraphBatch:
        graph = ShapeGraph(*(getattr(self.graph, f.name).to(device) for f in fields(self.graph)))
        return GraphBatch(graph, tuple(level.to(device) for level in self.levels), self.edge_counts)


def batch_graphs(shapes: Sequence[ShapeGraph]) -> GraphBatch:
    """Put shapes side by side."""
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


def _levels(graph: ShapeGraph) -> tuple[Level, ...]:
    edge_depths = graph.depths[graph.edges[:, 0]]
    place = torch.zeros_like(graph.parents)
    levels = []
    for depth in range(int(graph.depths.max()), 0, -1):
        children = torch.nonzero(graph.depths == depth).squeeze(1)
        place[children] = torch.arange(len(children))
        parents, slots = torch.unique(graph.parents[children], return_inverse=True)
        edges = torch.nonzero(edge_depths == depth).squeeze(1)
        starts, ends = place[graph.edges[edges]].unbind(1)
        levels.append(Level(children, parents, slots, edges, starts, ends))
    return tuple(levels)
