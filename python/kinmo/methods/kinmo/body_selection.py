"""Choice of the bodies that move among all proposals of bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_features import CandidateFeatures
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.symmetric_box import symmetric_box
from kinmo.methods.kinmo.body_ranking import features_of_groups
from kinmo.methods.kinmo.grouping.grouped_shape import Group, GroupedShape
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanker
from kinmo.methods.kinmo.ranking.ranked_joints import rank_joints, same_joint
from kinmo.methods.kinmo.ranking.shape_views import view_of_proposals

F64 = NDArray[np.float64]

MIN_MOTION_PROBABILITY = 0.5
"""Probability from which a proposal moves."""
MAX_OVERLAP = 0.05
"""Largest common share of the smaller of two bodies that are apart; 1 minus it is the least share if one lies in the other."""
MAX_INNER_AREA = 0.6
"""Largest area of a body inside another one, as a share of the outer one's."""
MIN_MISSED_AREA = 0.03
"""Least share of the shape's surface of a missed body; a missed pin or button spoils no pseudo label."""


@dataclass(frozen=True, eq=False)
class SelectedBodies:
    """Bodies that are chosen among proposals, the base first, in the order of their probability of motion.

    Attributes:
        bodies: Positions of the leaves of each body. Every leaf belongs to one body. Only the base may be empty.
        parents: Body that each body lies in as a proposal, such as the door of a knob; None for the base and for bodies apart.
        ranked: Ranked joints of each body, in the normalised frame and without limits.
        missed_motion_probability: Largest probability that a large proposal moves although it is not chosen. Proposals that
            overlap a chosen one do not count.
        features: Candidate features of all proposals; None without proposals.
    """

    bodies: tuple[Group, ...]
    parents: tuple[int | None, ...]
    ranked: tuple[tuple[JointEstimate, ...], ...]
    missed_motion_probability: float
    features: CandidateFeatures | None = None


def select_bodies(grouped: GroupedShape, geometry: ShapeGeometry, ranker: JointRanker) -> SelectedBodies:
    """Rank all proposals of bodies, and choose those that move.

    The annotation of the shape is not used. `geometry` is that of its leaves.
    """
    shape, proposals = grouped.shape, grouped.proposals
    everything = tuple(range(len(shape.leaves)))
    if not proposals:
        return SelectedBodies((everything,), (None,), (_base_at_rest(),), 0.0)
    features = features_of_groups(shape, geometry, proposals)
    probabilities, rest = ranker.probabilities(view_of_proposals(grouped, features, proposals))

    def ranked(row: int, still: float) -> tuple[JointEstimate, ...]:
        group, box = features.group_of[proposals[row]], symmetric_box(shape, proposals[row], geometry.meshes)
        return rank_joints(features, group, probabilities[row], still, box, shape.up)

    moves = 1.0 - rest
    likely = [int(row) for row in np.argsort(-moves, kind="stable") if moves[row] >= MIN_MOTION_PROBABILITY]
    found = {row: ranked(row, float(rest[row])) for row in likely}
    joints = {row: estimates[0].joint for row, estimates in found.items()}
    chosen = choose_consistent(proposals, {row: joint for row, joint in joints.items() if joint is not None}, shape.leaf_areas)
    bodies = innermost_owners([proposals[row] for row in chosen], len(everything), shape.leaf_areas)
    kept = [place for place, body in enumerate(bodies) if body]
    free = set(everything).difference(*(bodies[place] for place in kept))
    if not free and kept:  # something must rest: the body that moves least likely
        free = set(bodies[kept.pop()])
    rows = [chosen[place] for place in kept]
    return SelectedBodies(
        (tuple(sorted(free)), *(bodies[place] for place in kept)),
        (None, *_parents([proposals[row] for row in rows])),
        (_base_at_rest(), *(found[row] for row in rows)),
        _missed_motion(proposals, moves, [proposals[row] for row in rows], shape.leaf_areas),
        features,
    )


def choose_consistent(proposals: Sequence[Group], joints: dict[int, Joint], areas: F64) -> list[int]:
    """Rows of the proposals that are chosen, one after the other, if they agree with those before.

    Two bodies agree if they are apart, or one is much smaller, lies in the other, and has another joint.

    Args:
        proposals: Positions of the leaves of each proposal.
        joints: Best joints of the proposals that move, by row, in the order of their probability.
        areas: [L] surface areas of the leaves.
    """
    chosen: list[int] = []
    for row, joint in joints.items():
        own = set(proposals[row])
        own_area = float(areas[list(own)].sum())
        for other in chosen:
            its_area = float(areas[list(proposals[other])].sum())
            small, large = sorted((own_area, its_area))
            common = float(areas[list(own & set(proposals[other]))].sum()) / max(small, 1e-12)
            is_apart = common <= MAX_OVERLAP and not (own <= set(proposals[other]) or own >= set(proposals[other]))
            is_inside = common >= 1.0 - MAX_OVERLAP and small < MAX_INNER_AREA * large
            if not is_apart and not (is_inside and not same_joint(joints[other], joint)):
                break
        else:
            chosen.append(row)
    return chosen


def innermost_owners(bodies: Sequence[Group], count: int, areas: F64) -> list[Group]:
    """The bodies without the leaves of smaller bodies. `count` is the number of leaves, `areas` [L] are their surface areas."""
    owner = np.full(count, -1)
    for place in sorted(range(len(bodies)), key=lambda place: -areas[list(bodies[place])].sum()):
        owner[list(bodies[place])] = place
    return [tuple(np.flatnonzero(owner == place).tolist()) for place in range(len(bodies))]


def _parents(proposals: Sequence[Group]) -> list[int | None]:
    """The smallest other proposal of every chosen one that it lies in, counted from 1; None if there is none."""
    found: list[int | None] = []
    for place, own in enumerate(proposals):
        around = [other for other, its in enumerate(proposals) if other != place and set(own) < set(its)]
        found.append(min(around, key=lambda other: len(proposals[other])) + 1 if around else None)
    return found


def _missed_motion(proposals: Sequence[Group], moves: F64, chosen: Sequence[Group], areas: F64) -> float:
    moving = {leaf for group in chosen for leaf in group}
    least = MIN_MISSED_AREA * float(areas.sum())
    missed = [
        float(chance)
        for group, chance in zip(proposals, moves, strict=True)
        if moving.isdisjoint(group) and areas[list(group)].sum() >= least
    ]
    return max(missed, default=0.0)


def _base_at_rest() -> tuple[JointEstimate, ...]:
    return (JointEstimate(None, MotionType.FIXED, 1.0, source="ranking"),)
