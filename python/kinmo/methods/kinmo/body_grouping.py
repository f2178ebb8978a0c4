"""Grouping of moving nodes into rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import have_similar_size
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import TOUCHING
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.ranking.ranked_joints import same_joint

MIN_FIXED_PROBABILITY = 0.5
"""Mean probability of FIXED above which moving siblings form one body."""
MAX_SHAFT_OFFSET = 0.02
"""Largest distance, in diagonals, between the middle of a shaft and the axis it turns about."""
MIN_SHAFT_COSINE = 0.9
"""Least cosine between the longest axis of a shaft and the axis it turns about."""


def group_into_bodies(shape: PreparedShape, moving: Mapping[int, Joint], edges: EdgePredictions) -> list[tuple[int, ...]]:
    """Group moving nodes into bodies.

    Moving siblings form one body if the GNN predicts FIXED between them, they touch, they have the same joint, and their sizes
    differ. The front and the box of a drawer form one body, the keys of a keypad do not. A shaft forms one body
    with any touching sibling that has the same joint, such as the screen of a laptop, whatever the GNN predicts.

    Returns:
        Positions of the leaves of every body. Body 0 holds all leaves at rest; it may be empty.
    """
    fixed, sizes = edges.type_set.FIXED.value, shape.minimum_boxes.half_extents
    shafts = {node for node, joint in moving.items() if _is_shaft(shape, node, joint)}
    pairs: dict[tuple[int, int], list[float]] = {}
    for (part, other), probability, distance in zip(
        shape.edges.tolist(), edges.type_probabilities[:, fixed], shape.edge_distances, strict=True
    ):
        if part not in moving or other not in moving or distance > TOUCHING or have_similar_size(sizes[part], sizes[other]):
            continue
        if same_joint(moving[part], moving[other]):
            is_certain = part in shafts or other in shafts
            pairs.setdefault((min(part, other), max(part, other)), []).append(1.0 if is_certain else float(probability))
    leader = {node: node for node in moving}
    for pair, probabilities in pairs.items():
        if np.mean(probabilities) > MIN_FIXED_PROBABILITY:
            first, second = sorted(leader[node] for node in pair)
            leader = {node: first if old == second else old for node, old in leader.items()}
    owner = [0] * len(shape.parents)
    for node, parent in enumerate(shape.parents):
        owner[node] = leader[node] if node in leader else owner[parent] if parent >= 0 else 0
    leaves: dict[int, list[int]] = {body: [] for body in (0, *sorted(set(leader.values())))}
    for position, leaf in enumerate(shape.leaves):
        leaves[owner[leaf]].append(position)
    return [tuple(own) for body, own in leaves.items() if own or body == 0]


def _is_shaft(shape: PreparedShape, node: int, joint: Joint) -> bool:
    """True if a part turns about its own length: the axis of its joint runs along its box, through the middle."""
    boxes = shape.minimum_boxes
    offset = boxes.centers[node] - joint.pivot
    distance = np.linalg.norm(offset - (offset @ joint.direction) * joint.direction)
    longest = int(np.argmax(boxes.half_extents[node]))
    cosine = abs(float(boxes.axes[node, longest] @ joint.direction))
    return joint.kind is JointKind.REVOLUTE and bool(distance <= MAX_SHAFT_OFFSET) and cosine >= MIN_SHAFT_COSINE
