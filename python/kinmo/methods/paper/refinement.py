"""Refinement of predicted joints: the best candidate axis of every body (paper, section 3.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo import _core
from kinmo.config import RefinementConfig
from kinmo.core.joint import Joint
from kinmo.core.mobility import Mobility
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.joint_limits import JointLimits, estimate_joint_limits
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.symmetric_box import symmetric_box
from kinmo.learning.motion_gnn.gnn_estimate import GnnEstimate, gnn_joint
from kinmo.methods.paper.axis_selection.axis_selector import AxisSelector
from kinmo.methods.paper.candidate_axes import candidate_axes
from kinmo.methods.paper.candidate_scores import score_candidates
from kinmo.methods.paper.extra_candidates import EXTRA_SOURCES, line_candidates, merge_candidates, part_lines
from kinmo.methods.paper.interaction_region import interaction_centroid
from kinmo.methods.paper.leaf_roles import LeafRoles, leaf_roles
from kinmo.methods.paper.mobility_tree import MobilityTree

MAX_ESTIMATES = 10
"""Largest number of ranked joints per body."""


class Refiner:
    """Refinement of the bodies of mobility trees of one shape.

    Args:
        shape: The prepared shape.
        config: Candidates and weights of the scores.
        selector: Model of the feasibility score; None leaves that term out.
        meshes: Meshes of the leaves, in the normalised frame. Candidates beyond the paper's, the sweep term and limits need
            them; without them joints have no limits.

    Raises:
        ValueError: `config` needs meshes, and there are none.
    """

    def __init__(
        self,
        shape: PreparedShape,
        config: RefinementConfig,
        selector: AxisSelector | None = None,
        meshes: _core.Meshes | None = None,
    ) -> None:
        if meshes is None and (config.extra or config.sweeps):
            raise ValueError("meshes: needed for candidates beyond the paper's and for the sweep term")
        self.shape, self.config, self.selector, self.meshes = shape, config, selector, meshes

    def refine(self, tree: MobilityTree) -> ShapeEstimate:
        """The best joint of every body, its runners-up, and the joint that the GNN regressed, in the shape's own frame."""
        frame = Normalisation(self.shape.center, self.shape.diagonal)
        ranked, regressed, bodies = [], [], []
        for body, roles, estimate in zip(tree.bodies, leaf_roles(self.shape, tree.bodies), tree.estimates, strict=True):
            own = self._regressed(roles, estimate)
            found = self.estimates(roles, estimate) if estimate is not None else ()
            found = tuple(frame.undo_estimate(each) for each in (found or (replace(own, joint=None),)))
            ranked.append(found)
            regressed.append(frame.undo_estimate(own))
            bodies.append(replace(body, joint=found[0].joint))
        mobility = Mobility(tuple(bodies))
        return ShapeEstimate(self.shape.id, self.shape.category, mobility, tuple(ranked), tuple(regressed), "paper")

    def estimates(self, roles: LeafRoles, estimate: GnnEstimate) -> tuple[JointEstimate, ...]:
        """Ranked joints of one body, in the normalised frame; none if it is predicted not to move."""
        motion = estimate.type
        candidates = self.candidates(roles, motion)
        if not len(candidates):
            return ()
        selector = self.selector
        scores = score_candidates(
            candidates,
            estimate.direction,
            estimate.pivot,
            None if selector is None else selector.feasibility(self.shape, roles.moving, candidates),
            self._limits(roles, candidates).freedom if self.config.sweeps else None,
            weights=self.config.weights,
            reading=self.config.position,
        )
        best = np.argsort(-scores.total, kind="stable")[:MAX_ESTIMATES]
        chosen = candidates.subset(best)
        limits = self._limits(roles, chosen) if self.meshes is not None else None
        found = []
        for place, index in enumerate(best):
            lower, upper = (None, None) if limits is None else limits.range(place)
            joint = Joint(chosen.kind(place), chosen.directions[place], chosen.pivots[place], lower, upper)
            if joint.direction @ estimate.direction < 0:
                joint = joint.reversed()
            terms = {name: float(values[index]) for name, values in scores.terms.items()}
            terms |= {} if limits is None else {"sweep": float(limits.freedom[place])}
            found.append(JointEstimate(joint, motion, float(scores.total[index]), terms, chosen.sources[place]))
        return tuple(found)

    def candidates(self, roles: LeafRoles, motion: MotionType | CoarseType) -> CandidateJoints:
        """The paper's candidates of a body for a motion type, and those that `config.extra` adds."""
        if motion.kind is None:
            return CandidateJoints.empty()
        box = symmetric_box(self.shape, roles.own, self.meshes)
        central = isinstance(motion, MotionType) and motion.is_central
        wants_contact = central or self.config.contact_pivots == "revolute"
        contact = interaction_centroid(self.shape, roles) if wants_contact and self.config.contact_pivots != "none" else None
        found = candidate_axes(motion, box, self.shape.up, contact, self.config.contact_pivots)
        if not self.config.extra or self.meshes is None:
            return found
        sources = [source for name in self.config.extra for source in EXTRA_SOURCES[name]]
        lines = part_lines(self.shape, roles, self.meshes)
        return merge_candidates(found, line_candidates(motion, lines, self.shape.up, sources))

    def _limits(self, roles: LeafRoles, candidates: CandidateJoints) -> JointLimits:
        assert self.meshes is not None, "checked in __init__"
        points = self.shape.leaf_points[roles.own].reshape(-1, 3).astype(np.float64)
        return estimate_joint_limits(self.meshes, roles.moving, roles.obstacles, candidates, points)

    def _regressed(self, roles: LeafRoles, estimate: GnnEstimate | None) -> JointEstimate:
        """The joint that the motion GNN regressed, with limits if there are meshes."""
        found = gnn_joint(estimate)
        if found.joint is None or self.meshes is None:
            return found
        lower, upper = self._limits(roles, CandidateJoints.of([found.joint], [found.source])).range(0)
        return replace(found, joint=replace(found.joint, lower=lower, upper=upper))
