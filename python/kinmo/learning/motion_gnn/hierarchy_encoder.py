"""Features of every part of a hierarchy, from the leaves up, after StructureNet (Mo 2019; paper, section 3.2)."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from kinmo.config import GnnConfig
from kinmo.learning.layers import mlp, point_encoder, scatter_max, scatter_mean
from kinmo.learning.motion_gnn.hierarchy_graph import GraphBatch

BOX_CHANNELS = 15


class NameEmbedding(nn.Module):
    """The mean of the embeddings of a name's buckets (`kinmo.learning.name_encoding`)."""

    def __init__(self, buckets: int, features: int) -> None:
        super().__init__()
        self.table = nn.EmbeddingBag(buckets, features, mode="mean")  # of variance 1: smaller ones are hardly heeded

    def forward(self, ids: Tensor, counts: Tensor) -> Tensor:
        """`ids` [T], `counts` [N] -> [N, F]."""
        return self.table(ids, counts.cumsum(0) - counts)  # type: ignore[no-any-return]


class RelationEmbedding(nn.Module):
    """State and side of a pair of boxes, embedded and put one after the other, and (`pose` channels) their relative pose."""

    def __init__(self, states: int, sides: int, pose: int, features: int) -> None:
        super().__init__()
        self.state = nn.Embedding(states, features)
        self.side = nn.Embedding(sides, features)
        self.pose = mlp([pose, features], nn.ReLU) if pose else None
        self.features = features * (3 if pose else 2)

    def forward(self, states: Tensor, sides: Tensor, pose: Tensor) -> Tensor:
        pieces = [self.state(states), self.side(sides)]
        if self.pose is not None:
            pieces.append(self.pose(pose))
        return torch.cat(pieces, 1)


class ChildEncoder(nn.Module):
    """The feature of a parent from those of its children: messages along sibling edges, maxima before and after every round."""

    def __init__(self, width: int, name_width: int, edge_width: int, rounds: int, box_width: int) -> None:
        super().__init__()
        self.child = mlp([width + name_width, width], nn.ReLU)
        self.messages = nn.ModuleList(mlp([2 * width + edge_width, width], nn.ReLU) for _ in range(rounds))
        self.parent = mlp([(rounds + 1) * width + box_width, width], nn.ReLU)

    def forward(
        self, children: Tensor, names: Tensor, slots: Tensor, ends: tuple[Tensor, Tensor], edges: Tensor, boxes: Tensor
    ) -> Tensor:
        """`children` [C, W], `slots` [C] their parents, `ends` two of [M], `edges` [M, *], `boxes` [P, *] -> [P, W]."""
        features = self.child(torch.cat([children, names], 1))
        pooled = [scatter_max(features, slots, len(boxes))]
        starts, stops = ends
        for message in self.messages:
            sent = message(torch.cat([features[starts], features[stops], edges], 1))
            received, count = scatter_mean(sent, starts, len(features))
            features = torch.where((count > 0).unsqueeze(1), received, features)  # an only child keeps what it has
            pooled.append(scatter_max(features, slots, len(boxes)))
        return self.parent(torch.cat([*pooled, boxes], 1))  # type: ignore[no-any-return]


class HierarchyEncoder(nn.Module):
    """Leaves from their points and boxes; inner nodes from their children and, with `inner_boxes`, their own box too."""

    def __init__(self, config: GnnConfig, states: int, sides: int, pose: int) -> None:
        super().__init__()
        width = config.node_features
        self.width, self.inner_boxes = width, config.inner_boxes
        self.points = point_encoder(config.leaf)
        self.box = mlp([BOX_CHANNELS, config.box_features], nn.ReLU)
        self.leaf = mlp([self.points.features + config.box_features, width], nn.ReLU)
        self.names = NameEmbedding(config.name_buckets, 2 * config.name_features)
        self.relations = RelationEmbedding(states, sides, pose, config.relation_features)
        box_width = config.box_features if config.inner_boxes else 0
        self.children_encoder = ChildEncoder(
            width, 2 * config.name_features, self.relations.features, config.child_rounds, box_width
        )

    def forward(self, batch: GraphBatch) -> Tensor:
        """Features [N, node_features] of all parts of all shapes."""
        graph = batch.graph
        boxes = self.box(graph.boxes)
        names = self.names(graph.name_ids, graph.name_counts)
        edges = self.relations(graph.states, graph.sides, graph.pose)
        leaves = self.leaf(torch.cat([self.points(graph.leaf_points), boxes[graph.leaves]], 1))
        features: Tensor = leaves.new_zeros(len(graph.parents), self.width).index_copy(0, graph.leaves, leaves)
        for level in batch.levels:
            own = boxes[level.parents] if self.inner_boxes else boxes.new_zeros(len(level.parents), 0)
            parents = self.children_encoder(
                features[level.children],
                names[level.children],
                level.slots,
                (level.starts, level.ends),
                edges[level.edges],
                own,
            )
            features = features.index_copy(0, level.parents, parents)
        return features
