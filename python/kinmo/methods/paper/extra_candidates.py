"""Candidate axes beyond the paper's: from minimum-volume and axis-aligned boxes, contact, and rotational symmetry."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.core.joint import MAX_VERTICAL_ANGLE, JointKind
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.oriented_box import Box
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.candidate_lines import CandidateLines, LineSource, candidate_lines, distinct_directions
from kinmo.features.group_geometry import contact_weights
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.paper.leaf_roles import LeafRoles

EXTRA_SOURCES: dict[str, tuple[LineSource, ...]] = {
    "boxes": (
        LineSource.MINIMUM_BOX_EDGE,
        LineSource.MINIMUM_BOX_CENTER,
        LineSource.ALIGNED_BOX_EDGE,
        LineSource.ALIGNED_BOX_CENTER,
    ),
    "contact": (LineSource.CONTACT_LINE, LineSource.CONTACT_CENTER),
    "symmetry": (LineSource.SYMMETRY_AXIS,),
}
"""Sources of the candidates that `RefinementConfig.extra` names."""
CONTACT_POINTS = 96
"""Number of samples nearest to the obstacles that form the contact region."""
OBSTACLE_POINTS = 4096
"""Largest number of samples of the obstacles."""
AXIS_SYMMETRY = 1
"""Code of rotational symmetry about an axis in the geometry core."""
SAME_ANGLE = np.cos(np.radians(0.1))
"""Cosine above which the axes of two candidates are parallel (0.1 degrees)."""
SAME_DISTANCE = 1e-3
"""Distance, in diagonals, below which parallel candidates are the same."""


def part_lines(shape: PreparedShape, roles: LeafRoles, meshes: _core.Meshes) -> CandidateLines:
    """All candidate lines of a part: of its minimum and axis-aligned boxes, its contact, and its symmetry."""
    groups = [roles.own]
    minimum = Box(*(values[0] for values in _core.fit_boxes(meshes, groups)[:3]))
    aligned = Box(*(values[0] for values in _core.fit_aligned_boxes(meshes, np.eye(3), groups)[:3]))
    _, kinds, _, points, directions, _ = _core.find_symmetries(meshes, groups)
    symmetry = kinds == AXIS_SYMMETRY
    axes = np.stack([points[symmetry], directions[symmetry]], axis=1)
    own = shape.leaf_points[roles.own].reshape(-1, 3).astype(np.float64)
    if roles.obstacles:
        rest = shape.leaf_points[roles.obstacles].reshape(-1, 3)
        distances = cKDTree(rest[:: max(1, len(rest) // OBSTACLE_POINTS)]).query(own)[0]
    else:
        distances = np.ones(len(own))
    nearest = np.argsort(distances, kind="stable")[:CONTACT_POINTS]
    weights = contact_weights(distances[nearest])
    return candidate_lines(minimum, aligned, own[nearest], weights, {LineSource.SYMMETRY_AXIS: axes})


def line_candidates(
    motion: MotionType | CoarseType, lines: CandidateLines, up: NDArray[np.float64], sources: Sequence[LineSource]
) -> CandidateJoints:
    """Candidate joints of a motion type along the lines that come from one of `sources`.

    A fine type keeps the lines that are vertical or horizontal as the type says, or all lines if there are none. The scores
    decide whether an axis is central. Prismatic joints have one candidate per direction.
    """
    kind = motion.kind
    if kind is None or len(lines) == 0:
        return CandidateJoints.empty()
    chosen = np.flatnonzero(lines.sources[:, list(sources)].any(axis=1))
    if kind is JointKind.PRISMATIC:
        chosen = np.intersect1d(chosen, distinct_directions(lines))
    if isinstance(motion, MotionType):
        vertical = np.abs(lines.directions[chosen] @ up) > np.cos(MAX_VERTICAL_ANGLE)
        fitting = chosen[vertical == motion.is_vertical]
        chosen = fitting if len(fitting) else chosen
    names = tuple(LineSource(int(np.argmax(lines.sources[i]))).name.lower().replace("_", " ") for i in chosen)
    kinds = np.full(len(chosen), kind.code, np.uint8)
    return CandidateJoints(kinds, lines.directions[chosen], lines.pivots[chosen], names)


def merge_candidates(*sets: CandidateJoints) -> CandidateJoints:
    """Candidates of several sets, without repetitions; the first of equal candidates is kept.

    Candidates are equal if they have the same kind, parallel axes (0.1 degrees) and, except sliders, the same line (1e-3
    diagonals).
    """
    kinds = np.concatenate([s.kinds for s in sets])
    directions, pivots = (np.concatenate([getattr(s, name) for s in sets]) for name in ("directions", "pivots"))
    sources = tuple(source for s in sets for source in s.sources)
    kept: list[int] = []
    for index in range(len(kinds)):
        parallel = np.abs(directions[kept] @ directions[index]) > SAME_ANGLE
        offset = pivots[kept] - pivots[index]
        distance = np.linalg.norm(offset - (offset @ directions[index])[:, None] * directions[index], axis=1)
        slides = kinds[index] == JointKind.PRISMATIC.code
        if not (parallel & (kinds[kept] == kinds[index]) & (slides | (distance < SAME_DISTANCE))).any():
            kept.append(index)
    return CandidateJoints(kinds, directions, pivots, sources).subset(np.array(kept, np.intp))
