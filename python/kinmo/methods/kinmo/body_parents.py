"""Parents of bodies: the kinematic tree whose bodies have most contact with their parents.

Each possible parent of a body has a weight, the share of the body's surface in contact with it. The tree with the largest
product of weights is found as a maximum spanning arborescence (J. Edmonds, "Optimum branchings", 1967). A fork has more contact
with its wheel than with its chair. Still it is not the wheel's child, because then the wheel would hang on the chair, which it
hardly touches.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.vector import Vector
from kinmo.features.group_geometry import CONTACT_SCALE
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]

CONTACT_SAMPLES = 512
"""Surface samples of a body that its contact with other bodies is measured at."""
MOVING_WEIGHT = 0.6
"""Factor of the weight of parents that move: most parts hang on what rests."""
MIN_WEIGHT = 0.01
"""Weight that is added to all: that of a body far away."""
MAX_PARENTS = 6
"""Largest number of possible parents of a body, beside the best one that rests."""
PARALLEL = 0.98
"""Least cosine of the angle between directions that are called parallel."""
OVERLAP = 0.2
"""Share of the smaller of two outlines that must lie in the other one for a slider to be behind another one."""
REST = -1
"""Node of the tree that bodies at rest hang on."""
KNOWN, ALONE = 1e3, -1e3
"""Logarithmic weights of a known parent, and of none for a body that moves."""


def find_parents(
    geometry: ShapeGeometry,
    bodies: Sequence[Sequence[int]],
    joints: Sequence[Joint | None],
    known: Sequence[int | None] | None = None,
) -> list[int | None]:
    """Find the parent of every body that moves.

    What is attached to a body is not its parent, and sliders that move side by side, such as keys, do not carry each other.

    Args:
        geometry: Geometry of the leaves.
        bodies: Positions of the leaves of each body.
        joints: Joint of each body, in the normalised frame. None for bodies at rest.
        known: Parent of each body where it is known; None where it is not.

    Returns:
        Index of the parent of each body. None for bodies at rest, and where no body is left.
    """
    weights: list[dict[int, float]] = []
    beside = sliders_beside(geometry, bodies, joints)
    for index, joint in enumerate(joints):
        stated = None if known is None else known[index]
        if stated is not None:
            weights.append({stated: KNOWN, REST: ALONE})
        elif joint is not None:
            found = contacts(geometry, bodies, joints, index, beside[index])
            likely = {other: float(np.log(found[other] + MIN_WEIGHT)) for other in _best(found, joints)}
            weights.append({**likely, REST: ALONE})
        else:
            weights.append({REST: 0.0})
    return [None if parent == REST else parent for parent in best_tree(weights)]


def best_tree(weights: Sequence[Mapping[int, float]]) -> list[int]:
    """Parents with the largest sum of logarithmic weights that make up a tree below `REST`.

    Args:
        weights: Logarithmic weights of the possible parents of each body, `REST` among them.
    """
    parents = [max(own, key=lambda parent: own[parent]) for own in weights]
    settled = {REST}
    for start in range(len(parents)):
        chain = [start]
        while chain[-1] not in settled and parents[chain[-1]] not in chain:
            chain.append(parents[chain[-1]])
        if chain[-1] in settled:
            settled.update(chain)
    rest = [index for index in range(len(parents)) if index not in settled]  # they hang on a ring of bodies
    if rest:
        import networkx

        graph = networkx.DiGraph()
        for child in rest:
            best = max(settled & weights[child].keys(), key=lambda parent: weights[child][parent])
            graph.add_edge(REST, child, weight=weights[child][best], parent=best)
            loose = weights[child].keys() - settled
            graph.add_edges_from(
                (parent, child, {"weight": weights[child][parent], "parent": parent}) for parent in sorted(loose)
            )
        tree = networkx.maximum_spanning_arborescence(graph, preserve_attrs=True)
        for _, child, parent in tree.edges(data="parent"):
            parents[child] = parent
    return parents


def contacts(
    geometry: ShapeGeometry,
    bodies: Sequence[Sequence[int]],
    joints: Sequence[Joint | None],
    index: int,
    beside: Collection[int] = (),
) -> dict[int, float]:
    """Weights of the possible parents of a body that moves, for the arguments of `find_parents`.

    Args:
        index: The body.
        beside: Bodies that it does not hang on, unless there are no others.

    Returns:
        Share of the body's surface in contact with each other body, from 0 to 1, less for bodies that move.
    """
    points, _ = geometry.surface(bodies[index], CONTACT_SAMPLES)
    riders = set(geometry.surroundings(bodies[index])[1])
    others = [place for place, other in enumerate(bodies) if place != index and other and not set(other) <= riders]
    others = [other for other in others if other not in beside] or others
    if not others:
        return {}
    around = [list(bodies[other]) for other in others]
    gaps, _, _ = _core.closest_points_of_groups(geometry.meshes, around, np.broadcast_to(points, (len(around), *points.shape)))
    contact = np.exp(-(gaps - gaps.min()) / CONTACT_SCALE).mean(axis=1)
    return {
        other: float(share) * (1.0 if joints[other] is None else MOVING_WEIGHT)
        for other, share in zip(others, contact, strict=True)
    }


def _best(weights: dict[int, float], joints: Sequence[Joint | None]) -> list[int]:
    """The possible parents with the largest weights, and the best one that rests."""
    order = sorted(weights, key=lambda other: -weights[other])
    at_rest = [other for other in order if joints[other] is None]
    return list(dict.fromkeys([*order[:MAX_PARENTS], *at_rest[:1]]))


def sliders_beside(geometry: ShapeGeometry, bodies: Sequence[Sequence[int]], joints: Sequence[Joint | None]) -> list[set[int]]:
    """Parallel sliders beside every body that slides: neither behind it nor in front of it."""
    found: list[set[int]] = [set() for _ in bodies]
    sliders = {
        place: joint.direction
        for place, joint in enumerate(joints)
        if joint is not None and joint.kind is JointKind.PRISMATIC and bodies[place]
    }
    seen_along: dict[bytes, tuple[F64, F64]] = {}
    for one, direction in sliders.items():
        others = [other for other in sliders if other != one and abs(float(direction @ sliders[other])) >= PARALLEL]
        if not others:
            continue
        key = direction.tobytes()
        if key not in seen_along:
            seen_along[key] = _outlines(geometry, bodies, direction)
        low, high = seen_along[key]
        shared = np.prod(np.maximum(np.minimum(high[one], high[others]) - np.maximum(low[one], low[others]), 0.0), axis=1)
        areas = np.prod(high - low, axis=1)
        apart = shared < OVERLAP * np.minimum(areas[one], areas[others])
        found[one] = {other for other, is_apart in zip(others, apart, strict=True) if is_apart}
    return found


def _outlines(geometry: ShapeGeometry, bodies: Sequence[Sequence[int]], direction: Vector) -> tuple[F64, F64]:
    """Lower and upper corners [B, 2] of the boxes around all bodies, as seen along a direction; 0 for empty ones."""
    along = int(np.argmax(np.abs(geometry.frame @ direction)))
    across = np.delete(geometry.frame, along, axis=0)
    across = across - np.outer(across @ direction, direction)
    seen = geometry.points @ across.T
    low, high = seen.min(axis=1), seen.max(axis=1)
    lows = [low[list(body)].min(axis=0) if body else np.zeros(2) for body in bodies]
    highs = [high[list(body)].max(axis=0) if body else np.zeros(2) for body in bodies]
    return np.stack(lows), np.stack(highs)
