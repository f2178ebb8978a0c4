"""Trained networks as one object that answers for a shape."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.errors import InputError
from kinmo.evaluation.records import annotation
from kinmo.learning.axis_selection.predict import AxisSelector
from kinmo.learning.edge_predictions import EdgePredictions
from kinmo.learning.joint_ranking.predict import JointRanking
from kinmo.learning.joint_ranking.views import maximal_nodes
from kinmo.learning.motion_gnn.network import TypeSet
from kinmo.learning.motion_gnn.predict import MotionGnnPredictor
from kinmo.mobility import Mobility
from kinmo.mobility_tree import MobilityTree, given_tree, predicted_tree, retyped
from kinmo.normalisation import Normalisation
from kinmo.pipeline.model_files import METHOD_MODELS, WEIGHTS, model_folder, trained_config, weights_digest, weights_for
from kinmo.prediction import JointEstimate, Prediction
from kinmo.prepared import PreparedShape, check_unchanged
from kinmo.ranked_mobility import moving_nodes, network_estimates, predicted_bodies, ranked_bodies, tree_of
from kinmo.refinement import Refiner, in_file_frame
from kinmo.shape import Shape
from kinmo.type_odds import SAY
from kinmo.typed_tables import to_table
from kinmo.workspace import Workspace

NETWORKS_KEPT = 8
"""In memory, of each kind."""


class Predictor(Protocol):
    """Answers for shapes, in their own frame and lengths."""

    @property
    def method(self) -> str: ...

    @property
    def weights(self) -> str:
        """A hash of all networks that have a say."""

    @property
    def is_fine(self) -> bool:
        """Whether it tells ten types apart, or five."""

    @property
    def finds_parents(self) -> bool:
        """Whether, *parts given*, it says itself what every body is attached to, rather than being told."""

    @property
    def config(self) -> Mapping[str, Any]:
        """What else the answers depend on, as plain data."""

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """*Hierarchy given*: bodies and joints. `meshes` are those of the leaves, in the normalised frame."""

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """*Parts given*: the joints of the bodies of the shape's annotation."""

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        """*Parts given*, with the true types: at least of the bodies to which `predict_given` gives other ones."""

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64] | None:
        """The type [E] of every edge; None if the method does not go by them."""


@dataclass(frozen=True)
class PaperPredictor:
    """The paper's method: motion GNN of fine or coarse `types`, mobility tree, candidates, axis selection.

    Networks are read from `workspace` when they are first needed, those of a shape's own category where there are any.
    With `contact_edges` the motion GNN is the one that was trained on the edges between touching parts alone.
    """

    workspace: Workspace
    refinement: RefinementConfig
    types: TypeSet = "fine"
    device: str = "auto"
    hide_names: bool = False
    contact_edges: bool = False
    method: str = "paper"

    @cached_property
    def weights(self) -> str:
        return weights_digest(self.workspace, self._models)

    def check(self) -> None:
        """Raise InputError if one of the networks was never trained, or cannot be read."""
        for path in _all_weights(self.workspace, self._models[0]):
            _load_gnn(*path, self.device, self.hide_names)
        for path in _all_weights(self.workspace, "axis"):
            _load_selector(*path, self.device)

    @property
    def is_fine(self) -> bool:
        return self.types == "fine"

    @property
    def finds_parents(self) -> bool:
        return False

    @property
    def config(self) -> Mapping[str, Any]:
        return {"types": self.types, "refinement": to_table(self.refinement), "hide_names": self.hide_names}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        return self._refined(shape, meshes, predicted_tree(shape, self._gnn(shape).predict_edges(shape)))

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        return self._refined(shape, meshes, given_tree(shape, self._gnn(shape).predict_edges(shape)))

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        tree = given_tree(shape, self._gnn(shape).predict_edges(shape))
        return self._refined(shape, meshes, retyped(tree, shape.body_types))

    def edge_types(self, shape: PreparedShape) -> NDArray[np.int64]:
        return self._gnn(shape).predict_edges(shape).types

    def _refined(self, shape: PreparedShape, meshes: _core.Meshes, tree: MobilityTree) -> Prediction:
        selector = _load_selector(*_weights(self.workspace, "axis", shape.category), self.device)
        return Refiner(shape, self.refinement, selector, meshes).refine(tree, self.method)

    @property
    def _models(self) -> tuple[str, str]:
        return "gnn_contact" if self.contact_edges else f"gnn_{self.types}", "axis"

    def _gnn(self, shape: PreparedShape) -> MotionGnnPredictor:
        return _load_gnn(*_weights(self.workspace, self._models[0], shape.category), self.device, self.hide_names)


@dataclass(frozen=True)
class KinmoPredictor:
    """kinmo's own method: every motion that a part's geometry allows is ranked, and kind and axis are chosen together.

    The motion GNN says which moving siblings are one body, and has a word in how bodies move. Networks are read as in
    `PaperPredictor`.
    """

    workspace: Workspace
    device: str = "auto"
    hide_names: bool = False
    method: str = "kinmo"

    @cached_property
    def weights(self) -> str:
        return weights_digest(self.workspace, METHOD_MODELS["kinmo"])

    def check(self) -> None:
        """Raise InputError if one of the networks was never trained, or cannot be read."""
        for path in _all_weights(self.workspace, "gnn_fine"):
            _load_gnn(*path, self.device, self.hide_names)
        for path in _all_weights(self.workspace, "ranking"):
            _load_ranking(*path, self.device, self.hide_names)

    @property
    def is_fine(self) -> bool:
        return True

    @property
    def finds_parents(self) -> bool:
        return True

    @property
    def config(self) -> Mapping[str, Any]:
        return {"hide_names": self.hide_names, "say_of_types": SAY}

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        edges, ranking = self._edges(shape), self._ranking(shape)
        said = moving_nodes(shape, ranking, edges)
        bodies = predicted_bodies(shape, said.moving, edges)
        names = ["base", *(shape.part_names[maximal_nodes(shape, leaves)[0]] for leaves in bodies[1:])]
        answers = ranked_bodies(shape, meshes, bodies, ranking, edges, rests="first")
        return replace(self._assembled(shape, meshes, edges, bodies, names, answers), doubt=said.doubt)

    def predict_given(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        if shape.mobility is None:
            raise ValueError(f"shape {shape.id} is not annotated")
        names = [body.name for body in shape.mobility.bodies]
        edges = self._edges(shape)
        answers = ranked_bodies(shape, meshes, shape.body_leaves, self._ranking(shape), edges, rests="one")
        return self._assembled(shape, meshes, edges, shape.body_leaves, names, answers)

    def predict_typed(self, shape: PreparedShape, meshes: _core.Meshes) -> Prediction:
        mobility, _ = annotation(shape)
        kinds = [None if body.joint is None else body.joint.kind for body in mobility.bodies]
        answers = ranked_bodies(shape, meshes, shape.body_leaves, self._ranking(shape), self._edges(shape), kinds=kinds)
        bodies = tuple(replace(body, joint=found[0].joint) for body, found in zip(mobility.bodies, answers, strict=True))
        frame = Normalisation(shape.center, shape.diagonal)
        estimates = tuple(tuple(in_file_frame(answer, frame) for answer in found) for found in answers)
        return Prediction(shape.id, shape.category, frame.undo(Mobility(bodies)), estimates, (), self.method)

    def edge_types(self, shape: PreparedShape) -> None:
        return None

    def _assembled(
        self,
        shape: PreparedShape,
        meshes: _core.Meshes,
        edges: EdgePredictions,
        bodies: Sequence[tuple[int, ...]],
        names: Sequence[str],
        answers: Sequence[tuple[JointEstimate, ...]],
    ) -> Prediction:
        frame = Normalisation(shape.center, shape.diagonal)
        tree, limited = tree_of(shape, meshes, bodies, names, answers)
        estimates = tuple(tuple(in_file_frame(answer, frame) for answer in found) for found in limited)
        alone = tuple(in_file_frame(said, frame) for said in network_estimates(shape, bodies, edges))
        return Prediction(shape.id, shape.category, frame.undo(Mobility(tree)), estimates, alone, self.method)

    def _edges(self, shape: PreparedShape) -> EdgePredictions:
        gnn = _load_gnn(*_weights(self.workspace, "gnn_fine", shape.category), self.device, self.hide_names)
        return gnn.predict_edges(shape)

    def _ranking(self, shape: PreparedShape) -> JointRanking:
        return _load_ranking(*_weights(self.workspace, "ranking", shape.category), self.device, self.hide_names)


def _kinmo(workspace: Workspace, device: str) -> Predictor:
    predictor = KinmoPredictor(workspace, device)
    predictor.check()
    return predictor


def _paper(workspace: Workspace, device: str) -> Predictor:
    predictor = PaperPredictor(workspace, trained_config(workspace).refinement, device=device)
    predictor.check()
    return predictor


PREDICTORS: dict[str, Callable[[Workspace, str], Predictor]] = {"kinmo": _kinmo, "paper": _paper}
"""By method: the trained predictor of a workspace on a device. They raise InputError if a network is not trained."""


def load_predictor(workspace: Workspace, method: str, device: str) -> Predictor:
    """The trained predictor of a method. Raises InputError if there is no such method, or it is not trained."""
    if method not in PREDICTORS:
        raise InputError("--method", f"expected one of {', '.join(PREDICTORS)}, got {method}")
    return PREDICTORS[method](workspace, device)


@lru_cache(maxsize=NETWORKS_KEPT)
def _load_gnn(weights: Path, written: int, device: str, hide_names: bool) -> MotionGnnPredictor:
    return MotionGnnPredictor.load(weights, device, hide_names)


@lru_cache(maxsize=NETWORKS_KEPT)
def _load_ranking(weights: Path, written: int, device: str, hide_names: bool) -> JointRanking:
    return JointRanking.load(weights, device, hide_names)


@lru_cache(maxsize=NETWORKS_KEPT)
def _load_selector(weights: Path, written: int, device: str) -> AxisSelector:
    return AxisSelector.load(weights, device)


def _weights(workspace: Workspace, model: str, category: str) -> tuple[Path, int]:
    """The weights for a category, and when they were written (ns)."""
    path = weights_for(workspace, model, category)
    if path is None:
        raise InputError(model_folder(workspace, model), f"not trained for {category}: run kinmo train first")
    return path, path.stat().st_mtime_ns


def _all_weights(workspace: Workspace, model: str) -> list[tuple[Path, int]]:
    """All weights of a model, those of single categories too, and when they were written (ns)."""
    found = sorted(model_folder(workspace, model).rglob(WEIGHTS))
    if not found and not workspace.root.exists():
        raise InputError(workspace.root, "there is no such workspace: name one by --workspace, or run kinmo train motion first")
    if not found:
        raise InputError(model_folder(workspace, model), "not trained yet: run kinmo train motion first")
    return [(path, path.stat().st_mtime_ns) for path in found]


def leaf_meshes(shape: Shape, prepared: PreparedShape) -> _core.Meshes:
    """The leaves' meshes of `shape` in the normalised frame of `prepared`.

    Raises InputError where `shape` is not what was prepared.
    """
    check_unchanged(shape, prepared)
    frame = Normalisation(prepared.center, prepared.diagonal)
    meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    return _core.Meshes([mesh.vertices for mesh in meshes], [mesh.faces for mesh in meshes])


def normalised(estimates: Mapping[int, JointEstimate], shape: PreparedShape) -> dict[int, JointEstimate]:
    """Estimates in the file's frame, in the normalised frame of `shape`."""
    frame = Normalisation(shape.center, shape.diagonal)
    return {
        body: replace(found, joint=None if found.joint is None else frame.joint(found.joint))
        for body, found in estimates.items()
    }
