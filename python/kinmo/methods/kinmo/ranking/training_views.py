"""Views of annotated shapes that the ranking networks learn from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from kinmo.config import RankingConfig
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.kinmo.grouping.grouped_shape import GroupedShape, group_shape
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper
from kinmo.methods.kinmo.ranking.shape_views import (
    ShapeView,
    view_of_bodies,
    view_of_proposals,
    with_targets_of_bodies,
    with_targets_of_proposals,
)

NOISE = (0.5, 1.0)
"""Least and largest noise on the logits of the grouping networks, which are too sure of shapes that they were trained on."""

Group = tuple[int, ...]


def training_groups(shape: PreparedShape, grouper: PartGrouper, config: RankingConfig) -> tuple[Group, ...]:
    """All groups of leaves of an annotated shape whose candidate joints `training_views` needs."""
    proposals = [group for grouped in _groupings(shape, grouper, config) for group in grouped.proposals]
    return tuple(dict.fromkeys([*proposals, *filter(None, shape.body_leaves)]))


def training_views(shapes: Sequence[PreparedShape], grouper: PartGrouper, config: RankingConfig) -> list[ShapeView]:
    """Views of every annotated shape.

    They are proposals with the hierarchy if there is one, proposals without it, and the bodies. Groups without candidate
    features are left out.
    """
    return [view for shape in shapes for view in _views(shape, grouper, config)]


def _views(shape: PreparedShape, grouper: PartGrouper, config: RankingConfig) -> Iterator[ShapeView]:
    if not shape.candidate_features or shape.mobility is None:
        return
    features = CandidateFeatures.of(shape.candidate_features)
    groupings = _groupings(shape, grouper, config)
    for grouped in groupings:
        proposals = tuple(group for group in grouped.proposals if group in features.group_of)
        if proposals:
            yield with_targets_of_proposals(view_of_proposals(grouped, features, proposals), shape, proposals)
    if shape.body_leaves and all(shape.body_leaves):
        view = view_of_bodies(groupings[0], features, shape.body_leaves)
        yield with_targets_of_bodies(view, shape.mobility)


def _groupings(shape: PreparedShape, grouper: PartGrouper, config: RankingConfig) -> list[GroupedShape]:
    """The shape as the grouping networks join it, with the hierarchy if there is one, and without.

    What is hidden is drawn for the shape, the same at every call.
    """
    rng = np.random.default_rng(list(f"{shape.id} {shape.geometry_hash}".encode()))
    found = []
    for shows_hierarchy in (True, False):
        shows_names, noise = bool(rng.random() >= config.hide_names), float(rng.uniform(*NOISE))
        options = {"shows_names": shows_names, "shows_hierarchy": shows_hierarchy}
        grouped = group_shape(shape, grouper, **options, noise=noise, rng=rng)
        if grouped.shows_hierarchy is shows_hierarchy:
            found.append(grouped)
    return found
