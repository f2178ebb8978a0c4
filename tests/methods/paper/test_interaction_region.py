"""Interaction region of a movable part and its reference part (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace

from edge_predictions import predictions_from_labels
from small_shapes import cabinet

from kinmo.methods.paper.interaction_region import interaction_centroid
from kinmo.methods.paper.leaf_roles import leaf_roles
from kinmo.methods.paper.mobility_tree import tree_with_given_bodies


def test_interaction_regions_lie_between_the_parts() -> None:
    shape = cabinet(0)
    tree = tree_with_given_bodies(shape, predictions_from_labels(shape))
    for body, roles in zip(tree.bodies, leaf_roles(shape, tree.bodies), strict=True):
        if body.parent is not None:
            centroid = interaction_centroid(shape, roles)
            own = shape.leaf_points[roles.own].reshape(-1, 3)
            assert (centroid >= own.min(axis=0) - 0.02).all()
            assert (centroid <= own.max(axis=0) + 0.02).all()
    assert interaction_centroid(shape, replace(roles, reference=[])) is None
