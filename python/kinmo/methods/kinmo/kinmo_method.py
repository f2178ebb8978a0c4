"""kinmo's own method: every motion that a part's geometry allows is ranked, and kind and axis are chosen together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

from kinmo import _core
from kinmo.core.mobility import Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.gnn_prior import SAY
from kinmo.methods.kinmo.ranked_mobility import moving_nodes, network_estimates, predicted_bodies, ranked_bodies, tree_of
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanking
from kinmo.methods.kinmo.ranking.shape_views import maximal_nodes
from kinmo.methods.method import NETWORKS_KEPT, load_gnn


@dataclass(frozen=True)
class KinmoMethod:
    """kinmo's own method.

    The ranking networks choose kind and axis of each part. The motion GNN groups moving siblings into bodies, and its type
    probabilities are a prior for the ranking. Networks are read from `models` when they are first needed; a category's own
    networks come before those of all.

    Attributes:
        models: the folder with the trained networks.
        device: where networks run.
        hide_names: hide the names of all parts.
    """

    models: ModelFolder
    device: str = "auto"
    hide_names: bool = False
    name: str = "kinmo"
    is_fine: bool = True
    finds_parents: bool = True

    @cached_property
    def weights(self) -> str:
        """Hash of all networks that take part."""
        return self.models.digest(("gnn_fine", "ranking"))

    def check(self) -> None:
        """Raise InputError if one of the networks is missing or cannot be read."""
        for path in self.models.all_weights("gnn_fine"):
            load_gnn(path, self.device, self.hide_names)
        for path in self.models.all_weights("ranking"):
            _load_ranking(path, path.stat().st_mtime_ns, self.device, self.hide_names)

    @property
    def config(self) -> Mapping[str, Any]:
        """Everything but the networks that predictions depend on."""
        return {"hide_names": self.hide_names, "say_of_types": SAY}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict bodies and joints from the hierarchy."""
        edges, ranking = self._edges(shape), self._ranking(shape)
        nodes = moving_nodes(shape, ranking, edges)
        bodies = predicted_bodies(shape, nodes.moving, edges)
        names = ["base", *(shape.part_names[maximal_nodes(shape, leaves)[0]] for leaves in bodies[1:])]
        ranked = ranked_bodies(shape, meshes, bodies, ranking, edges, rests="first")
        return replace(self._assembled(shape, meshes, edges, bodies, names, ranked), doubt=nodes.doubt)

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict the joints of the annotated bodies."""
        mobility, _ = shape.annotation
        names = [body.name for body in mobility.bodies]
        edges = self._edges(shape)
        ranked = ranked_bodies(shape, meshes, shape.body_leaves, self._ranking(shape), edges, rests="one")
        return self._assembled(shape, meshes, edges, shape.body_leaves, names, ranked)

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """Predict the joints of the annotated bodies, with their true kinds."""
        mobility, _ = shape.annotation
        kinds = [None if body.joint is None else body.joint.kind for body in mobility.bodies]
        ranked = ranked_bodies(shape, meshes, shape.body_leaves, self._ranking(shape), self._edges(shape), kinds=kinds)
        bodies = tuple(replace(body, joint=found[0].joint) for body, found in zip(mobility.bodies, ranked, strict=True))
        frame = Normalisation(shape.center, shape.diagonal)
        estimates = tuple(tuple(frame.undo_estimate(estimate) for estimate in found) for found in ranked)
        return Prediction(shape.id, shape.category, frame.undo(Mobility(bodies)), estimates, (), self.name)

    def edge_types(self, shape: PreparedShape) -> None:
        """None: the method does not use the types of edges by themselves."""

    def _assembled(
        self,
        shape: PreparedShape,
        meshes: _core.Meshes,
        edges: EdgePredictions,
        bodies: Sequence[tuple[int, ...]],
        names: Sequence[str],
        ranked: Sequence[tuple[JointEstimate, ...]],
    ) -> Prediction:
        """A prediction in the shape's own frame, from ranked estimates in the normalised one."""
        frame = Normalisation(shape.center, shape.diagonal)
        tree, limited = tree_of(shape, meshes, bodies, names, ranked)
        estimates = tuple(tuple(frame.undo_estimate(estimate) for estimate in found) for found in limited)
        alone = tuple(frame.undo_estimate(estimate) for estimate in network_estimates(shape, bodies, edges))
        return Prediction(shape.id, shape.category, frame.undo(Mobility(tree)), estimates, alone, self.name)

    def _edges(self, shape: PreparedShape) -> EdgePredictions:
        gnn = load_gnn(self.models.weights_for("gnn_fine", shape.category), self.device, self.hide_names)
        return gnn.predict_edges(shape)

    def _ranking(self, shape: PreparedShape) -> JointRanking:
        weights = self.models.weights_for("ranking", shape.category)
        return _load_ranking(weights, weights.stat().st_mtime_ns, self.device, self.hide_names)


@lru_cache(maxsize=NETWORKS_KEPT)
def _load_ranking(weights: Path, written: int, device: str, hide_names: bool) -> JointRanking:
    return JointRanking.load(weights, device, hide_names)
