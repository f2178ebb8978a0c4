"""The `kinmo` method: candidate joints of all parts are ranked, and kind and axis of a joint are chosen together.

*Parts given*: the candidates of every body are ranked, and the best becomes its joint. *Hierarchy given*: the nodes are ranked
first. Nodes that move are grouped into bodies, and the bodies are ranked like given ones. The motion GNN's types are a prior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from kinmo import _core
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.body_grouping import group_into_bodies
from kinmo.methods.kinmo.body_ranking import rank_bodies
from kinmo.methods.kinmo.gnn_prior import PRIOR_POWER, gnn_estimates
from kinmo.methods.kinmo.kinematic_tree import build_tree
from kinmo.methods.kinmo.moving_nodes import find_moving_nodes
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
        return "gnn_fine", "ranking"

    @property
    def config(self) -> Mapping[str, Any]:
        """Settings that predictions depend on, as plain data."""
        return {"hide_names": self.hide_names, "gnn_prior_power": PRIOR_POWER}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict bodies and joints (setting *hierarchy given*); see `Method.predict`."""
        edges, ranker = self._edges(shape), self._ranker(shape)
        nodes = find_moving_nodes(shape, ranker, edges)
        bodies = group_into_bodies(shape, nodes.moving, edges)
        names = ["base", *(shape.part_names[maximal_nodes(shape, leaves)[0]] for leaves in bodies[1:])]
        ranked = rank_bodies(shape, meshes, bodies, ranker, edges, may_rest="first")
        prediction = self._assemble(shape, meshes, edges, bodies, names, ranked)
        return replace(prediction, missed_motion_probability=nodes.missed_motion_probability)

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies (setting *parts given*); see `Method.predict_given`."""
        mobility, _ = shape.annotation
        names = [body.name for body in mobility.bodies]
        edges = self._edges(shape)
        ranked = rank_bodies(shape, meshes, shape.body_leaves, self._ranker(shape), edges, may_rest="one")
        return self._assemble(shape, meshes, edges, shape.body_leaves, names, ranked)

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        """Predict the joints of the annotated bodies, with their true kinds."""
        mobility, _ = shape.annotation
        kinds = [None if body.joint is None else body.joint.kind for body in mobility.bodies]
        ranked = rank_bodies(shape, meshes, shape.body_leaves, self._ranker(shape), self._edges(shape), kinds=kinds)
        bodies = tuple(replace(body, joint=found[0].joint) for body, found in zip(mobility.bodies, ranked, strict=True))
        return self._in_file_frame(shape, bodies, ranked, [])

    def _assemble(
        self,
        shape: PreparedShape,
        meshes: _core.Meshes,
        edges: EdgePredictions,
        bodies: Sequence[tuple[int, ...]],
        names: Sequence[str],
        ranked: Sequence[tuple[JointEstimate, ...]],
    ) -> ShapeEstimate:
        """The prediction from ranked joints in the normalised frame."""
        tree, limited = build_tree(shape, meshes, bodies, names, ranked)
        return self._in_file_frame(shape, tree, limited, gnn_estimates(shape, bodies, edges))

    def _in_file_frame(
        self,
        shape: PreparedShape,
        bodies: tuple[Body, ...],
        ranked: Sequence[tuple[JointEstimate, ...]],
        regressed: Sequence[JointEstimate],
    ) -> ShapeEstimate:
        """The prediction in the shape's own frame, from bodies and joints in the normalised frame."""
        frame = Normalisation(shape.center, shape.diagonal)
        estimates = tuple(tuple(frame.undo_estimate(estimate) for estimate in found) for found in ranked)
        of_gnn = tuple(frame.undo_estimate(estimate) for estimate in regressed)
        return ShapeEstimate(shape.id, shape.category, frame.undo_mobility(Mobility(bodies)), estimates, of_gnn, self.name)

    def _ranker(self, shape: PreparedShape) -> JointRanker:
        ranker: JointRanker = self._network("ranking", shape)
        return ranker

    def _load(self, model: str, weights: Path) -> Any:
        if model == "ranking":
            return load_network(JointRanker.load, weights, self.device, self.hide_names)
        return super()._load(model, weights)
