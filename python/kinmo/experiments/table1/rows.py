"""The rows of Table 1 for one shape: who answers what in which setting."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import JointKind
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.dataset.workspace import Workspace
from kinmo.experiments.label_truth import WEIGHTS, weighted_score
from kinmo.experiments.table1.rule_baseline import without_learning
from kinmo.experiments.table1.upper_bound import ceiling
from kinmo.features.part_geometry import part_geometries
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.model_folder import ModelFolder
from kinmo.learning.motion_gnn.gnn_network import TypeSet
from kinmo.methods.kinmo.kinmo_method import KinmoMethod
from kinmo.methods.method import Method
from kinmo.methods.paper.paper_method import PaperMethod
from kinmo.methods.paper.refinement import Refiner

TYPE_SETS: tuple[TypeSet, ...] = ("coarse", "fine")
SWEPT = (0.5, 0.3, 0.2, 0.5)
"""Weights with the swept collision as a fourth term."""

CONTACT_EDGES = "OBB_fine, contact edges"
CEILING, NO_LEARNING = "ceiling", "no learning"


def as_predicted(prediction: Prediction) -> Prediction:
    """The prediction itself."""
    return prediction


def network_alone(prediction: Prediction) -> Prediction:
    """What the network said before refinement, as a prediction of its own."""
    bodies = tuple(
        replace(body, joint=said.joint)
        for body, said in zip(prediction.mobility.bodies, prediction.network_estimates, strict=True)
    )
    mobility = replace(prediction.mobility, bodies=bodies)
    return replace(prediction, mobility=mobility, estimates=tuple((said,) for said in prediction.network_estimates))


@dataclass(frozen=True)
class Row:
    """A row: its name, who predicts, and how its answers are made from the prediction. Rows share the predictor's work."""

    name: str
    predictor: Method
    of: Callable[[Prediction], Prediction] = as_predicted


def paper_rows(predictors: Mapping[TypeSet, PaperMethod]) -> list[Row]:
    """The paper's four rows; `predictors` by type set."""
    rows = []
    for types in TYPE_SETS:
        rows.append(Row(f"GNN_{types}", predictors[types], network_alone))
        rows.append(Row(f"OBB_{types}", predictors[types]))
    return rows


def weight_rows(fine: PaperMethod) -> list[Row]:
    """OBB_fine with other weights of the same terms."""
    others = {name: weights for name, weights in WEIGHTS.items() if name in ("feasibility alone", "consistency alone")}
    others["equal weights"] = {"feasibility": 1.0, "direction": 1.0, "position": 1.0}
    return [Row(f"OBB_fine, {name}", fine, Reweighted(weights)) for name, weights in others.items()]


def ablation_rows(fine: PaperMethod) -> list[Row]:
    """OBB_fine with candidates beyond the paper's, and with the swept term."""
    config = fine.refinement

    def changed(**values: object) -> PaperMethod:
        return replace(fine, refinement=replace(config, **values))  # type: ignore[arg-type]

    return [
        Row("OBB_fine, both boxes", changed(extra=("boxes",))),
        Row("OBB_fine, contact lines", changed(extra=("contact",))),
        Row("OBB_fine, symmetry axes", changed(extra=("symmetry",))),
        Row("OBB_fine, all candidates", changed(extra=("boxes", "contact", "symmetry"))),
        Row("OBB_fine, swept term", changed(weights=SWEPT)),
        Row("OBB_fine, contact pivots of all hinges", changed(contact_pivots="revolute")),
    ]


def contact_edge_rows(fine: PaperMethod) -> list[Row]:
    """The fine rows with edges between touching parts only, by a network trained so; none if it is not trained."""
    contact = replace(fine, contact_edges=True)
    if not contact.weights:
        return []
    return [Row("GNN_fine, contact edges", contact, network_alone), Row(CONTACT_EDGES, contact)]


def hidden_name_rows(predictors: Mapping[TypeSet, PaperMethod]) -> list[Row]:
    """The fine rows with all part names hidden."""
    hidden = replace(predictors["fine"], hide_names=True)
    return [Row("GNN_fine, names hidden", hidden, network_alone), Row("OBB_fine, names hidden", hidden)]


@dataclass(frozen=True)
class Reweighted:
    """A prediction with its answers ranked anew by other weights of their terms."""

    weights: Mapping[str, float]

    def __call__(self, prediction: Prediction) -> Prediction:
        estimates = tuple(tuple(sorted(map(self._scored, found), key=_by_score)) for found in prediction.estimates)
        bodies = tuple(replace(b, joint=e[0].joint) for b, e in zip(prediction.mobility.bodies, estimates, strict=True))
        return replace(prediction, mobility=replace(prediction.mobility, bodies=bodies), estimates=estimates)

    def _scored(self, estimate: JointEstimate) -> JointEstimate:
        slides = estimate.joint is not None and estimate.joint.kind is JointKind.PRISMATIC
        terms = {name: value for name, value in estimate.terms.items() if not (slides and name == "position")}
        score = weighted_score(terms, self.weights)
        return estimate if score is None else replace(estimate, score=score)


def _by_score(estimate: JointEstimate) -> float:
    return -estimate.score


def frame_answers(
    truth: PreparedShape, meshes: _core.Meshes, config: RefinementConfig, trees: Mapping[int, JointEstimate] | None
) -> Iterator[tuple[str, Mapping[int, JointEstimate]]]:
    """The rows that frame the table, *parts given*: the best that candidates allow, a rule without learning, and `trees`."""
    yield f"{CEILING}, paper's candidates", ceiling(truth, true_type_candidates(truth, meshes, config))
    every = replace(config, extra=("boxes", "contact", "symmetry"), contact_pivots="revolute")
    yield f"{CEILING}, all candidates", ceiling(truth, true_type_candidates(truth, meshes, every))
    yield NO_LEARNING, without_learning(truth)
    if trees is not None:
        yield "trees", trees


def true_type_candidates(
    truth: PreparedShape, meshes: _core.Meshes | None, config: RefinementConfig
) -> dict[int, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Directions and pivots of the candidates of every movable body, its true type known (`meshes`: see `Refiner`)."""
    mobility, _ = truth.annotation
    parts = part_geometries(truth, mobility.bodies)
    refiner = Refiner(truth, config, None, meshes)
    found = {index: refiner.candidates(parts[index], truth.body_types[index]) for index, _ in mobility.movable()}
    return {index: (candidates.directions, candidates.pivots) for index, candidates in found.items()}


def chosen_rows(
    workspace: Workspace, methods: Sequence[str], device: str, ablations: bool = False, hidden_names: bool = False
) -> list[Row]:
    """The rows of `methods` in the order of printing. Raises InputError if a method's networks are not trained."""
    rows: list[Row] = []
    models = ModelFolder(workspace.motion.models)
    if "kinmo" in methods:
        own = KinmoMethod(models, device)
        own.check()
        rows.append(Row("kinmo", own))
        rows += [Row("kinmo, names hidden", replace(own, hide_names=True))] if hidden_names else []
    if "paper" in methods:
        config = models.config().refinement
        predictors = {types: PaperMethod(models, config, types, device) for types in TYPE_SETS}
        for predictor in predictors.values():
            predictor.check()
        rows += paper_rows(predictors) + weight_rows(predictors["fine"])
        rows += ablation_rows(predictors["fine"]) + contact_edge_rows(predictors["fine"]) if ablations else []
        rows += hidden_name_rows(predictors) if hidden_names else []
    return rows
