"""Network of the motion GNN: messages over the sibling edges of all levels, and a head for every edge (paper, section 3.2)."""

from __future__ import annotations

from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from kinmo.config import GnnConfig
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.learning.motion_gnn.hierarchy_encoder import HierarchyEncoder, NameEmbedding, RelationEmbedding
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch
from kinmo.learning.network_layers import mlp, scatter_mean

KIND = "motion_gnn"
"""Kind of network in the header of its weights (`kinmo.learning.weights`)."""
TypeSet = Literal["fine", "coarse"]
CLASSES: dict[TypeSet, int] = {"fine": len(MotionType), "coarse": len(CoarseType)}
"""Number of motion types in each set."""

MIN_EXTENT_RATIO = 0.2
"""Least half extent of a box in `from_box`, as a share of its longest half extent."""


class EdgeOutput(NamedTuple):
    """Output of the network for E edges.

    Attributes:
        logits: Scores of the motion types [E, C].
        directions: Unit axis directions [E, 3].
        pivots: Points on the axes [E, 3] in the normalised frame.
    """

    logits: Tensor
    directions: Tensor
    pivots: Tensor


class TripleConvolution(nn.Module):
    """One round of messages over (moving part, edge, reference part) triples; a part takes the mean over its triples."""

    def __init__(self, node: int, edge: int, hidden: int, features: int) -> None:
        super().__init__()
        self.hidden, self.features = hidden, features
        self.triple = mlp([2 * node + edge, hidden, 2 * hidden + features], nn.LeakyReLU)
        self.node = mlp([hidden, hidden, features], nn.LeakyReLU)

    def forward(self, nodes: Tensor, edges: Tensor, ends: Tensor) -> tuple[Tensor, Tensor]:
        """Features of the parts [N, features] and edges [E, features], from those before and the parts of each edge [E, 2]."""
        moving, reference = ends.unbind(1)
        triples = self.triple(torch.cat([nodes[moving], edges, nodes[reference]], 1))
        to_moving, along, to_reference = triples.split([self.hidden, self.features, self.hidden], 1)
        pooled, _ = scatter_mean(torch.cat([to_moving, to_reference]), torch.cat([moving, reference]), len(nodes))
        return self.node(pooled), along


class MotionGnn(nn.Module):
    """The motion GNN: scores of motion types, a direction and a pivot for every edge of a batch of hierarchies.

    The head predicts directions and pivots in the box of the moving part (`along_box`, `from_box`).
    """

    def __init__(self, config: GnnConfig, types: int) -> None:
        super().__init__()
        self.types = types
        self.encoder = HierarchyEncoder(config)
        self.names = NameEmbedding(config.name_buckets, config.name_features)
        self.relations = RelationEmbedding(config.relation_features)
        node, edge = config.node_features + config.name_features, self.relations.features
        rounds = []
        for _ in range(config.graph_rounds):
            rounds.append(TripleConvolution(node, edge, config.graph_hidden, config.graph_features))
            node = edge = config.graph_features
        self.rounds = nn.ModuleList(rounds)
        self.head = mlp([edge, config.head_features, config.head_features, types + 6], nn.LeakyReLU, last=False)
        for module in (self.rounds, self.head):
            for layer in module.modules():
                if isinstance(layer, nn.Linear):
                    nn.init.kaiming_normal_(layer.weight)

    def forward(self, batch: GraphBatch) -> EdgeOutput:
        """Output for all E edges of a batch."""
        graph = batch.graph
        nodes = torch.cat([self.encoder(batch), self.names(graph.name_ids, graph.name_counts)], 1)
        edges = self.relations(graph.states, graph.sides)
        for convolution in self.rounds:
            nodes, edges = convolution(nodes, edges, graph.edges)
        logits, pivots, directions = self.head(edges).split([self.types, 3, 3], 1)
        boxes = graph.boxes[graph.edges[:, 0]]
        return EdgeOutput(logits, along_box(directions, boxes), from_box(pivots, boxes))


def along_box(components: Tensor, boxes: Tensor) -> Tensor:
    """Unit directions [E, 3] from their components [E, 3], of any length, along the axes of boxes [E, 15]."""
    return normalize(torch.einsum("ei,eij->ej", components, boxes[:, 6:].view(-1, 3, 3)), dim=1)


def from_box(coordinates: Tensor, boxes: Tensor) -> Tensor:
    """Points [E, 3] from their coordinates [E, 3] in half extents of boxes [E, 15], along the axes of the boxes.

    The coordinates of a box's edges and middle are -1, 0 and 1, whatever its size and place. Thin half extents count as
    `MIN_EXTENT_RATIO` of the longest, so that a point off a plate can be predicted.
    """
    centers, half_extents, axes = boxes[:, :3], boxes[:, 3:6] / 2, boxes[:, 6:].view(-1, 3, 3)
    reach = torch.maximum(half_extents, MIN_EXTENT_RATIO * half_extents.amax(1, keepdim=True))
    return centers + torch.einsum("ei,eij->ej", coordinates * reach, axes)
