"""Encoder of part hierarchies, from the leaves up, after StructureNet (Mo et al. 2019; paper, section 3.2)."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from kinmo.config import GnnConfig
from kinmo.learning.motion_gnn.box_relations import SIDES, STATES
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch, HierarchyLevel
from kinmo.learning.network_layers import mlp, point_encoder, scatter_max, scatter_mean

BOX_CHANNELS = 15
"""Number of values of a box: centre (3), full size (3), axes (9)."""


class NameEmbedding(nn.Module):
    """Mean embedding, `features` wide, of the hash buckets of each name (`kinmo.learning.name_encoding`)."""

    def __init__(self, buckets: int, features: int) -> None:
        super().__init__()
        self.table = nn.EmbeddingBag(buckets, features, mode="mean")  # of variance 1: the network nearly ignores smaller ones

    def forward(self, ids: Tensor, counts: Tensor) -> Tensor:
        """Embeddings [N, F] of N names, from the buckets of all names `ids` [T] and the number of each name `counts` [N]."""
        return self.table(ids, counts.cumsum(0) - counts)  # type: ignore[no-any-return]


class RelationEmbedding(nn.Module):
    """Embedding of the relation of two boxes: state and side (`box_relations`), concatenated to 2 * `features`."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.state = nn.Embedding(len(STATES), features)
        self.side = nn.Embedding(len(SIDES), features)
        self.features = 2 * features

    def forward(self, states: Tensor, sides: Tensor) -> Tensor:
        """Features [E, self.features] of E edges with `states` [E] and `sides` [E]."""
        return torch.cat([self.state(states), self.side(sides)], 1)


class ChildEncoder(nn.Module):
    """Feature of a parent from its children: rounds of messages along sibling edges, with a maximum before and after each."""

    def __init__(self, width: int, name_width: int, edge_width: int, rounds: int, box_width: int) -> None:
        super().__init__()
        self.child = mlp([width + name_width, width], nn.ReLU)
        self.messages = nn.ModuleList(mlp([2 * width + edge_width, width], nn.ReLU) for _ in range(rounds))
        self.parent = mlp([(rounds + 1) * width + box_width, width], nn.ReLU)

    def forward(self, level: HierarchyLevel, parts: Tensor, names: Tensor, edges: Tensor, boxes: Tensor) -> Tensor:
        """Features [P, width] of a level's P parents.

        They come from features and names of all parts, features of all edges, and the parents' box features [P, box_width].
        """
        features = self.child(torch.cat([parts[level.children], names[level.children]], 1))
        between = edges[level.edges]
        pooled = [scatter_max(features, level.slots, len(boxes))]
        for message in self.messages:
            sent = message(torch.cat([features[level.starts], features[level.ends], between], 1))
            received, count = scatter_mean(sent, level.starts, len(features))
            features = torch.where((count > 0).unsqueeze(1), received, features)  # an only child keeps its features
            pooled.append(scatter_max(features, level.slots, len(boxes)))
        return self.parent(torch.cat([*pooled, boxes], 1))  # type: ignore[no-any-return]


class HierarchyEncoder(nn.Module):
    """Features of all parts: leaves from their points and boxes, inner parts from their children.

    With `GnnConfig.inner_boxes`, inner parts also see their own box.
    """

    def __init__(self, config: GnnConfig) -> None:
        super().__init__()
        width = config.node_features
        self.width, self.inner_boxes = width, config.inner_boxes
        self.points = point_encoder(config.leaf)
        self.box = mlp([BOX_CHANNELS, config.box_features], nn.ReLU)
        self.leaf = mlp([self.points.features + config.box_features, width], nn.ReLU)
        self.names = NameEmbedding(config.name_buckets, 2 * config.name_features)
        self.relations = RelationEmbedding(config.relation_features)
        edge_width, box_width = self.relations.features, config.box_features if config.inner_boxes else 0
        self.children_encoder = ChildEncoder(width, 2 * config.name_features, edge_width, config.child_rounds, box_width)

    def forward(self, batch: GraphBatch) -> Tensor:
        """Features [N, node_features] of all N parts of all shapes."""
        graph = batch.graph
        boxes = self.box(graph.boxes)
        names = self.names(graph.name_ids, graph.name_counts)
        edges = self.relations(graph.states, graph.sides)
        leaves = self.leaf(torch.cat([self.points(graph.leaf_points), boxes[graph.leaves]], 1))
        features: Tensor = leaves.new_zeros(len(graph.parents), self.width).index_copy(0, graph.leaves, leaves)
        for level in batch.levels:
            own = boxes[level.parents] if self.inner_boxes else boxes.new_zeros(len(level.parents), 0)
            features = features.index_copy(0, level.parents, self.children_encoder(level, features, names, edges, own))
        return features
