"""Messages over sibling edges of all levels, and what each edge says (paper, section 3.2)."""

from __future__ import annotations

from typing import Literal, NamedTuple

import torch
from torch import Tensor, nn
from torch.nn.functional import normalize

from kinmo.config import GnnConfig
from kinmo.core.joint import CoarseType, MotionType
from kinmo.learning.layers import mlp, scatter_mean
from kinmo.learning.motion_gnn.box_relations import POSE_FEATURES, SIDES, STATES
from kinmo.learning.motion_gnn.hierarchy_encoder import HierarchyEncoder, NameEmbedding, RelationEmbedding
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch

KIND = "motion_gnn"
"""The name of its weights (`learning.weights`)."""
TypeSet = Literal["fine", "coarse"]
CLASSES: dict[TypeSet, int] = {"fine": len(MotionType), "coarse": len(CoarseType)}

EDGE_CHANNELS = POSE_FEATURES + 2
"""Relative pose, distance and contact."""

LEAST_REACH = 0.2
"""Of a box's longest half extent."""


class EdgeOutput(NamedTuple):
    """Of E edges: `logits` [E, types], unit `directions` [E, 3], `pivots` [E, 3] in the normalised frame."""

    logits: Tensor
    directions: Tensor
    pivots: Tensor


class TripleConvolution(nn.Module):
    """One round of messages over (moving part, edge, reference part) triples: every part takes the mean over its triples."""

    def __init__(self, node: int, edge: int, hidden: int, features: int) -> None:
        super().__init__()
        self.hidden, self.features = hidden, features
        self.triple = mlp([2 * node + edge, hidden, 2 * hidden + features], nn.LeakyReLU)
        self.node = mlp([hidden, hidden, features], nn.LeakyReLU)

    def forward(self, nodes: Tensor, edges: Tensor, ends: Tensor) -> tuple[Tensor, Tensor]:
        """`nodes` [N, *], `edges` [E, *], `ends` [E, 2] -> [N, features], [E, features]."""
        moving, reference = ends.unbind(1)
        triples = self.triple(torch.cat([nodes[moving], edges, nodes[reference]], 1))
        to_moving, along, to_reference = triples.split([self.hidden, self.features, self.hidden], 1)
        pooled, _ = scatter_mean(torch.cat([to_moving, to_reference]), torch.cat([moving, reference]), len(nodes))
        return self.node(pooled), along


class MotionGnn(nn.Module):
    """A motion type of `types`, a direction and a pivot for every edge of a batch of hierarchies.

    Pivots are told in the moving part's box (`from_box`).
    """

    def __init__(self, config: GnnConfig, types: int) -> None:
        super().__init__()
        self.types = types
        pose = EDGE_CHANNELS if config.inputs == "kinmo" else 0
        self.encoder = HierarchyEncoder(config, len(STATES), len(SIDES), pose)
        self.names = NameEmbedding(config.name_buckets, config.name_features)
        self.relations = RelationEmbedding(len(STATES), len(SIDES), pose, config.relation_features)
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
        graph = batch.graph
        nodes = torch.cat([self.encoder(batch), self.names(graph.name_ids, graph.name_counts)], 1)
        edges = self.relations(graph.states, graph.sides, graph.pose)
        for convolution in self.rounds:
            nodes, edges = convolution(nodes, edges, graph.edges)
        logits, pivots, directions = self.head(edges).split([self.types, 3, 3], 1)
        boxes = graph.boxes[graph.edges[:, 0]]
        return EdgeOutput(logits, along_box(directions, boxes), from_box(pivots, boxes))


def along_box(parts: Tensor, boxes: Tensor) -> Tensor:
    """Unit vectors [E, 3] of the normalised frame from their `parts` [E, 3] along the axes of `boxes` [E, 15]."""
    return normalize(torch.einsum("ei,eij->ej", parts, boxes[:, 6:].view(-1, 3, 3)), dim=1)


def from_box(places: Tensor, boxes: Tensor) -> Tensor:
    """Points [E, 3] of the normalised frame from `places` [E, 3] in the half extents of `boxes` [E, 15].

    The edges and the middle of a box are -1, 0 and 1 there, whatever its size and place. Thin extents count as a fifth of the
    longest, so that a point off a plate can be said.
    """
    centers, half_extents, axes = boxes[:, :3], boxes[:, 3:6] / 2, boxes[:, 6:].view(-1, 3, 3)
    reach = torch.maximum(half_extents, LEAST_REACH * half_extents.amax(1, keepdim=True))
    return centers + torch.einsum("ei,eij->ej", places * reach, axes)
