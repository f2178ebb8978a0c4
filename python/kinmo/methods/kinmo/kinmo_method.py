"""The `kinmo` method: parts are grouped into proposals of bodies, and the candidate joints of all of them are ranked.

*Hierarchy given*, or a flat list of parts: a network on the graph of touching parts joins the leaves to a merge tree. Its nodes
are proposals of bodies. The ranking networks tell which of them move and how, and those that agree become bodies.
*Parts given*: the candidate joints of the given bodies are ranked.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from kinmo import _core
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods.kinmo.body_ranking import rank_bodies
from kinmo.methods.kinmo.body_selection import select_bodies
from kinmo.methods.kinmo.grouping.grouped_shape import Group, GroupedShape, group_shape
from kinmo.methods.kinmo.grouping.part_grouper import PartGrouper
from kinmo.methods.kinmo.kinematic_tree import build_tree
from kinmo.methods.kinmo.limits.limits_predictor import LimitsPredictor
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.name_words import maximal_nodes
from kinmo.methods.method import Method, load_network


@dataclass(frozen=True)
class KinmoMethod(Method):
    """The `kinmo` method (see `Method`)."""

    models: ModelFolder
    device: str = "auto"
    hide_names: bool = False
    name: ClassVar[str] = "kinmo"
    finds_parents: ClassVar[bool] = True

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""
        return "grouping", "ranking", "limits"

    @property
    def config(self) -> Mapping[str, Any]:
        """Settings that predictions depend on, as plain data."""
        return {"hide_names": self.hide_names}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict bodies and joints (setting *hierarchy given*); see `Method.predict`."""
        bare, geometry = replace(shape, mobility=None), ShapeGeometry.of_prepared(shape, meshes)
        found = select_bodies(self._grouped(bare), geometry, self._ranker(shape))
        names = ["base", *(_name_of(shape, body) for body in found.bodies[1:])]
        tree, limited = build_tree(
            bare, geometry, found.bodies, names, found.ranked, self._limiter(shape), found.parents, found.features
        )
        prediction = self._in_file_frame(shape, tree, limited)
        return replace(prediction, missed_motion_probability=found.missed_motion_probability)

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*); see `Method.predict_given`."""
        mobility, _ = shape.annotation
        names, geometry = [body.name for body in mobility.bodies], ShapeGeometry.of_prepared(shape, meshes)
        ranked = rank_bodies(self._grouped(shape), geometry, shape.body_leaves, self._ranker(shape), may_rest="one")
        tree, limited = build_tree(shape, geometry, shape.body_leaves, names, ranked, self._limiter(shape))
        return self._in_file_frame(shape, tree, limited)

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies, with their true kinds."""
        mobility, _ = shape.annotation
        kinds = [None if body.joint is None else body.joint.kind for body in mobility.bodies]
        geometry = ShapeGeometry.of_prepared(shape, meshes)
        ranked = rank_bodies(self._grouped(shape), geometry, shape.body_leaves, self._ranker(shape), kinds=kinds)
        bodies = tuple(replace(body, joint=found[0].joint) for body, found in zip(mobility.bodies, ranked, strict=True))
        return self._in_file_frame(shape, bodies, ranked)

    def _in_file_frame(
        self, shape: PreparedShape, bodies: tuple[Body, ...], ranked: Sequence[tuple[JointEstimate, ...]]
    ) -> ShapeEstimate:
        """The prediction in the shape's own frame with calibrated scores, from bodies and joints in the normalised frame."""
        frame, ranker = Normalisation(shape.center, shape.diagonal), self._ranker(shape)
        scored = (tuple(replace(each, score=ranker.calibrated(each.score)) for each in found) for found in ranked)
        estimates = tuple(tuple(frame.undo_estimate(estimate) for estimate in found) for found in scored)
        return ShapeEstimate(shape.id, shape.category, frame.undo_mobility(Mobility(bodies)), estimates, (), self.name)

    def _grouped(self, shape: PreparedShape) -> GroupedShape:
        """The shape as the grouping networks join its leaves."""
        grouper: PartGrouper = self._network("grouping", shape)
        return group_shape(shape, grouper, shows_names=not self.hide_names)

    def _ranker(self, shape: PreparedShape) -> JointRanker:
        ranker: JointRanker = self._network("ranking", shape)
        return ranker

    def _limiter(self, shape: PreparedShape) -> LimitsPredictor:
        limiter: LimitsPredictor = self._network("limits", shape)
        return limiter

    def _load(self, model: str, weights: Path) -> Any:
        load = {"grouping": PartGrouper.load, "ranking": JointRanker.load, "limits": LimitsPredictor.load}[model]
        return load_network(load, weights, self.device, self.hide_names)


def _name_of(shape: PreparedShape, body: Group) -> str:
    """Name of a body: what the names of its highest nodes begin with, or else the name of the largest of them."""
    nodes = maximal_nodes(shape, body)
    names = [shape.part_names[node] for node in nodes]
    words = [re.findall(r"[^\W_]+", name) for name in names]
    leading = [some[0] for some in takewhile(lambda some: len(set(some)) == 1, zip(*words, strict=False))]
    if len(names) > 1 and any(not word.isdecimal() for word in leading):
        return "_".join(leading)
    areas = [float(np.sum(shape.leaf_areas[list(shape.leaves_below[node])])) for node in nodes]
    return names[int(np.argmax(areas))]
