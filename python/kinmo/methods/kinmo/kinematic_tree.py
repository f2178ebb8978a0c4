"""Kinematic tree of ranked bodies: the parent of every body, and the limits of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinmo import _core
from kinmo.core.mobility import Body, descendants
from kinmo.core.shape_estimate import JointEstimate
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.group_geometry import CONTACT_SCALE
from kinmo.features.joint_limits import estimate_joint_limits
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry

CONTACT_SAMPLES = 512
"""Surface samples of a body that its contact with other bodies is measured at."""


def build_tree(
    shape: PreparedShape,
    meshes: _core.Meshes,
    bodies: Sequence[tuple[int, ...]],
    names: Sequence[str],
    ranked: Sequence[tuple[JointEstimate, ...]],
    known: Sequence[int | None] | None = None,
) -> tuple[tuple[Body, ...], list[tuple[JointEstimate, ...]]]:
    """Bodies with their parents and best joints, and all ranked joints with limits, in the normalised frame.

    `bodies` are the positions of the leaves of each body, `ranked` its ranked joints without limits, `known` its parent where
    that is known.
    """
    parents = find_parents(shape, meshes, bodies, [found[0].joint is not None for found in ranked], known)
    limited = []
    for index, found in enumerate(ranked):
        moving = sorted(leaf for body in descendants(parents, index) for leaf in bodies[body])
        limited.append(add_limits(found, shape, meshes, moving))
    tree = tuple(
        Body(index, name, tuple(shape.leaves[position] for position in leaves), parents[index], found[0].joint)
        for index, (name, leaves, found) in enumerate(zip(names, bodies, limited, strict=True))
    )
    return tree, limited


def find_parents(
    shape: PreparedShape,
    meshes: _core.Meshes,
    bodies: Sequence[tuple[int, ...]],
    moves: Sequence[bool],
    known: Sequence[int | None] | None = None,
) -> list[int | None]:
    """Parent of every moving body: the `known` one, or else the body it has most contact with.

    A body that is attached to another one is not its parent. Bodies at rest (not `moves`) have no parent.
    """
    geometry = ShapeGeometry.of_prepared(shape, meshes)
    affinity = np.full((len(bodies), len(bodies)), -1.0)
    parents: list[int | None] = [None] * len(bodies) if known is None else list(known)
    for index, leaves in enumerate(bodies):
        if not moves[index] or parents[index] is not None:
            continue
        points, _ = geometry.surface(leaves, CONTACT_SAMPLES)
        _, riders = geometry.surroundings(leaves)
        others = [place for place, other in enumerate(bodies) if place != index and other and not set(other) <= set(riders)]
        if others:
            gaps = np.array([_core.closest_points(meshes, list(bodies[place]), points)[0] for place in others])
            affinity[index, others] = np.exp(-(gaps - gaps.min()) / CONTACT_SCALE).mean(axis=1)
    for flat in np.argsort(-affinity, axis=None, kind="stable"):
        index, other = divmod(int(flat), len(bodies))
        if affinity[index, other] < 0:
            break
        if parents[index] is None and other not in descendants(parents, index):
            parents[index] = other
    return parents


def add_limits(
    ranked: Sequence[JointEstimate], shape: PreparedShape, meshes: _core.Meshes, moving: Sequence[int]
) -> tuple[JointEstimate, ...]:
    """Ranked joints of one body with limits, directions that point to the longer side of the range, and the term `sweep`.

    The best joint is swept alone, so that its limits do not depend on the others. `moving` are the positions of all leaves that
    move with the body.
    """
    return (*_add_limits(ranked[:1], shape, meshes, moving), *_add_limits(ranked[1:], shape, meshes, moving))


def _add_limits(
    ranked: Sequence[JointEstimate], shape: PreparedShape, meshes: _core.Meshes, moving: Sequence[int]
) -> list[JointEstimate]:
    """The estimates with limits from one sweep; those without a joint are unchanged."""
    joints = {place: estimate.joint for place, estimate in enumerate(ranked) if estimate.joint is not None}
    limited = list(ranked)
    if not joints:
        return limited
    candidates = CandidateJoints.of(list(joints.values()), [ranked[place].source for place in joints])
    obstacles = sorted(set(range(len(shape.leaves))) - set(moving))
    points = shape.leaf_points[list(moving)].reshape(-1, 3).astype(np.float64)
    limits = estimate_joint_limits(meshes, moving, obstacles, candidates, points)
    for row, (place, joint) in enumerate(joints.items()):
        lower, upper = limits.range(row)
        joint = replace(joint, lower=lower, upper=upper)
        if lower is not None and upper is not None and -lower > upper:
            joint = joint.reversed()
        terms = {**ranked[place].terms, "sweep": float(limits.freedom[row])}
        limited[place] = replace(ranked[place], joint=joint, terms=terms)
    return limited
