"""The most plausible joint of every body, among candidates from its geometry (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import CoarseType, Joint, MotionType
from kinmo.core.mobility import Body, Mobility
from kinmo.core.normalisation import Normalisation
from kinmo.core.prediction import JointEstimate, Prediction
from kinmo.features.candidate_joints import Candidates, line_candidates, merged, no_candidates, paper_candidates
from kinmo.features.candidate_lines import Source
from kinmo.features.free_travel import Travel, free_travel
from kinmo.features.part_geometry import PartGeometry, interaction_centroid, lines_of, part_geometries, symmetric_box
from kinmo.features.prepared_shape import PreparedShape
from kinmo.learning.motion_gnn.gnn_estimate import GnnEstimate, gnn_joint
from kinmo.methods.paper.mobility_tree import MobilityTree
from kinmo.methods.paper.scoring import Scores, score

F64 = NDArray[np.float64]

ALTERNATIVES = 10
"""So many answers are kept for a body."""

EXTRA_SOURCES: dict[str, tuple[Source, ...]] = {
    "boxes": (Source.MINIMUM_BOX_EDGE, Source.MINIMUM_BOX_CENTER, Source.ALIGNED_BOX_EDGE, Source.ALIGNED_BOX_CENTER),
    "contact": (Source.CONTACT_LINE, Source.CONTACT_CENTER),
    "symmetry": (Source.SYMMETRY_AXIS,),
}
"""Candidates beyond the paper's, by the name that RefinementConfig.extra has for them."""


class FeasibilityScorer(Protocol):
    """What gives s^f: `kinmo.methods.paper.axis_selection.axis_selector.AxisSelector` does."""

    def score_candidates(self, shape: PreparedShape, moving: list[int], candidates: Candidates) -> F64: ...


class Refiner:
    """Candidates, scores and limits for the bodies of one mobility tree.

    Without a `selector` there is no feasibility term. `meshes` (of the leaves, in the normalised frame) are needed for
    candidates beyond the paper's, the sweep term and limits; without them joints have no limits.
    """

    def __init__(
        self,
        shape: PreparedShape,
        config: RefinementConfig,
        selector: FeasibilityScorer | None = None,
        meshes: _core.Meshes | None = None,
    ) -> None:
        if meshes is None and (config.extra or config.sweeps):
            raise ValueError("meshes: needed for candidates beyond the paper's and for the sweep term")
        self.shape, self.config, self.selector, self.meshes = shape, config, selector, meshes

    def refine(self, tree: MobilityTree, method: str = "paper") -> Prediction:
        """The best joint of every body, its runners-up, and what the network alone said, in the shape's own frame."""
        parts = part_geometries(self.shape, tree.bodies)
        frame = Normalisation(self.shape.center, self.shape.diagonal)
        ranked, network, bodies = [], [], []
        for body, part, estimate in zip(tree.bodies, parts, tree.estimates, strict=True):
            said = self._network_estimate(part, estimate)
            answers = self.estimates(part, estimate) if estimate is not None else ()
            answers = tuple(frame.undo_estimate(answer) for answer in (answers or (replace(said, joint=None),)))
            ranked.append(answers)
            network.append(frame.undo_estimate(said))
            bodies.append(Body(body.id, body.name, body.leaves, body.parent, answers[0].joint))
        mobility = Mobility(tuple(bodies))
        return Prediction(self.shape.id, self.shape.category, mobility, tuple(ranked), tuple(network), method)

    def estimates(self, part: PartGeometry, estimate: GnnEstimate) -> tuple[JointEstimate, ...]:
        """Ranked joints for one body, in the normalised frame; empty if it is not thought to move."""
        motion = estimate.type
        candidates = self.candidates(part, motion)
        if not len(candidates):
            return ()
        travel = self._travel(part, candidates) if self.config.sweeps else None
        scores = self.scores(part, estimate, candidates, travel)
        best = np.argsort(-scores.total, kind="stable")[:ALTERNATIVES]
        chosen = _subset(candidates, best)
        travel = self._travel(part, chosen) if self.meshes is not None else None
        answers = []
        for place, index in enumerate(best):
            limits = (None, None) if travel is None else travel.range(place)
            joint = _oriented(chosen, place, limits, estimate.direction)
            terms = {name: float(values[index]) for name, values in scores.terms.items()}
            terms |= {} if travel is None else {"sweep": float(travel.freedom[place])}
            answers.append(JointEstimate(joint, motion, float(scores.total[index]), terms, chosen.sources[place]))
        return tuple(answers)

    def candidates(self, part: PartGeometry, motion: MotionType | CoarseType) -> Candidates:
        """The paper's candidates for the motion type, and those that `config.extra` adds."""
        if motion.kind is None:
            return no_candidates()
        box = symmetric_box(self.shape, part.leaves, self.meshes)
        central = isinstance(motion, MotionType) and motion.is_central
        wants_contact = central or self.config.contact_pivots == "revolute"
        contact = interaction_centroid(self.shape, part) if wants_contact and self.config.contact_pivots != "none" else None
        found = paper_candidates(motion, box, self.shape.up, contact, self.config.contact_pivots)
        if not self.config.extra or self.meshes is None:
            return found
        sources = [source for name in self.config.extra for source in EXTRA_SOURCES[name]]
        return merged(found, line_candidates(motion, lines_of(self.shape, part, self.meshes), self.shape.up, sources))

    def scores(self, part: PartGeometry, estimate: GnnEstimate, candidates: Candidates, travel: Travel | None = None) -> Scores:
        """Feasibility, consistency and swept freedom of some candidates, weighed as configured."""
        feasibility = None if self.selector is None else self.selector.score_candidates(self.shape, part.moving, candidates)
        return score(
            candidates,
            estimate.direction,
            estimate.pivot,
            feasibility,
            None if travel is None else travel.freedom,
            weights=self.config.weights,
            reading=self.config.position,
        )

    def _travel(self, part: PartGeometry, candidates: Candidates) -> Travel:
        assert self.meshes is not None, "checked when the refiner was made"
        points = self.shape.leaf_points[part.leaves].reshape(-1, 3).astype(np.float64)
        return free_travel(self.meshes, part.moving, part.obstacles, candidates, points)

    def _network_estimate(self, part: PartGeometry, estimate: GnnEstimate | None) -> JointEstimate:
        said = gnn_joint(estimate)
        if said.joint is None or self.meshes is None:
            return said
        kind, axis = said.joint.kind.code, said.joint
        alone = Candidates(np.array([kind], np.uint8), axis.direction[None], axis.pivot[None], (said.source,))
        lower, upper = self._travel(part, alone).range(0)
        return replace(said, joint=replace(axis, lower=lower, upper=upper))


def _oriented(candidates: Candidates, index: int, limits: tuple[float | None, float | None], towards: F64) -> Joint:
    """The joint of one candidate, its direction (and with it its range) turned to the side of the network's."""
    joint = Joint(candidates.kind(index), candidates.directions[index], candidates.pivots[index], *limits)
    return joint.reversed() if joint.direction @ towards < 0 else joint


def _subset(candidates: Candidates, rows: NDArray[np.intp]) -> Candidates:
    return Candidates(
        candidates.kinds[rows],
        candidates.directions[rows],
        candidates.pivots[rows],
        tuple(candidates.sources[index] for index in rows),
    )
