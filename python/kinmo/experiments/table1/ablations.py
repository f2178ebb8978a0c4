"""Ablations of the paper's method: other score weights, candidates, edges, and hidden names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.evaluation.joint_records import score_terms
from kinmo.experiments.label_truth import WEIGHTS, weighted_score
from kinmo.learning.model_folder import ModelFolder
from kinmo.methods.kinmo.kinmo_method import KinmoMethod
from kinmo.methods.paper.paper_method import PaperMethod
from kinmo.pipeline.evaluation.method_rows import Row, gnn_alone

SWEEP_WEIGHTS = (0.5, 0.3, 0.2, 0.5)
"""Weights of feasibility, direction, position, and of the free travel as a fourth term."""
CONTACT_EDGES = "OBB_fine, contact edges"


@dataclass(frozen=True)
class Reweighted:
    """Change of a prediction: its estimates ranked anew with other `weights` of their terms."""

    weights: Mapping[str, float]

    def __call__(self, prediction: ShapeEstimate) -> ShapeEstimate:
        estimates = tuple(
            tuple(sorted(map(self._rescored, found), key=lambda estimate: -estimate.score)) for found in prediction.estimates
        )
        bodies = tuple(replace(b, joint=e[0].joint) for b, e in zip(prediction.mobility.bodies, estimates, strict=True))
        return replace(prediction, mobility=replace(prediction.mobility, bodies=bodies), estimates=estimates)

    def _rescored(self, estimate: JointEstimate) -> JointEstimate:
        score = weighted_score(score_terms(estimate), self.weights)
        return estimate if score is None else replace(estimate, score=score)


@dataclass(frozen=True)
class AblationRows:
    """Adds ablations of OBB_fine, or rows without part names, to other rows (see `evaluate_shapes.MoreRows`)."""

    ablations: bool = False
    hidden_names: bool = False

    def __call__(self, models: ModelFolder, rows: Sequence[Row], device: str) -> list[Row]:
        methods = {row.name: row.method for row in rows}
        found: list[Row] = []
        kinmo, fine = methods.get("kinmo"), methods.get("OBB_fine")
        if self.hidden_names and isinstance(kinmo, KinmoMethod):
            found.append(Row("kinmo, names hidden", replace(kinmo, hide_names=True)))
        if isinstance(fine, PaperMethod):
            if self.ablations:
                found += [*weight_rows(fine), *candidate_rows(fine), *contact_edge_rows(fine)]
            if self.hidden_names:
                hidden = replace(fine, hide_names=True)
                found += [Row("GNN_fine, names hidden", hidden, gnn_alone), Row("OBB_fine, names hidden", hidden)]
        return found

    def missing(self, rows: Sequence[Row]) -> str:
        """Sentence about the rows of contact edges, if they were asked for and their network is not trained."""
        is_wanted = self.ablations and any(row.name == "OBB_fine" for row in rows)
        if not is_wanted or any(row.name == CONTACT_EDGES for row in rows):
            return ""
        return "No rows of contact edges: their network is not trained (kinmo train contact-edges)."


def weight_rows(fine: PaperMethod) -> list[Row]:
    """OBB_fine with other weights of the same terms."""
    others = {name: weights for name, weights in WEIGHTS.items() if name in ("feasibility alone", "consistency alone")}
    others["equal weights"] = {"feasibility": 1.0, "direction": 1.0, "position": 1.0}
    return [Row(f"OBB_fine, {name}", fine, Reweighted(weights)) for name, weights in others.items()]


def candidate_rows(fine: PaperMethod) -> list[Row]:
    """OBB_fine with candidates beyond the paper's, and with the sweep as a term of the score."""

    def changed(name: str, **values: object) -> Row:
        return Row(f"OBB_fine, {name}", replace(fine, refinement=replace(fine.refinement, **values)))  # type: ignore[arg-type]

    return [
        changed("both boxes", extra=("boxes",)),
        changed("contact lines", extra=("contact",)),
        changed("symmetry axes", extra=("symmetry",)),
        changed("all candidates", extra=("boxes", "contact", "symmetry")),
        changed("sweep term", weights=SWEEP_WEIGHTS),
        changed("contact pivots of all hinges", contact_pivots="revolute"),
    ]


def contact_edge_rows(fine: PaperMethod) -> list[Row]:
    """Fine rows of a GNN with edges between touching parts only; none if it is not trained."""
    contact = replace(fine, contact_edges=True)
    if not contact.weights:
        return []
    return [Row("GNN_fine, contact edges", contact, gnn_alone), Row(CONTACT_EDGES, contact)]
