"""The `kinmo` method: candidate joints of all parts are ranked, and kind and axis of a joint are chosen together.

*Parts given*: the candidates of every body are ranked, and the best becomes its joint. *Hierarchy given*: the nodes are ranked
first. Nodes that move are grouped into bodies, and the bodies are ranked like given ones. The motion GNN's types are a prior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

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
from kinmo.methods.method import CACHED_NETWORKS, load_gnn


@dataclass(frozen=True)
class KinmoMethod:
    """The `kinmo` method.

    Networks are read from `models` when they are first needed. Networks trained for one category alone take precedence.

    Attributes:
        models: The folder with the trained networks.
        device: Where networks run.
        hide_names: Hide the names of all parts.
        name: Name of the method.
        is_fine: True: the method predicts ten motion types.
        finds_parents: True: with parts given, the method predicts the parents of bodies.
    """

    models: ModelFolder
    device: str = "auto"
    hide_names: bool = False
    name: str = "kinmo"
    is_fine: bool = True
    finds_parents: bool = True

    @property
    def model_names(self) -> tuple[str, ...]:
        """Names of its models in the folder of trained networks."""
        return "gnn_fine", "ranking"

    @cached_property
    def weights(self) -> str:
        """Hash of all networks of the method."""
        return self.models.digest(self.model_names)

    def check(self) -> None:
        """Check that all networks can be read.

        Raises:
            InputError: A network is missing or cannot be read.
        """
        for path in self.models.all_weights("gnn_fine"):
            load_gnn(path, self.device, self.hide_names)
        for path in self.models.all_weights("ranking"):
            _load_ranker(path, path.stat().st_mtime_ns, self.device, self.hide_names)

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

    def edge_types(self, shape: PreparedShape) -> None:
        """None: the method does not use edge types by themselves."""

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

    def _edges(self, shape: PreparedShape) -> EdgePredictions:
        gnn = load_gnn(self.models.weights_for("gnn_fine", shape.category), self.device, self.hide_names)
        return gnn.predict_edges(shape)

    def _ranker(self, shape: PreparedShape) -> JointRanker:
        weights = self.models.weights_for("ranking", shape.category)
        return _load_ranker(weights, weights.stat().st_mtime_ns, self.device, self.hide_names)


@lru_cache(maxsize=CACHED_NETWORKS)
def _load_ranker(weights: Path, written: int, device: str, hide_names: bool) -> JointRanker:
    return JointRanker.load(weights, device, hide_names)
