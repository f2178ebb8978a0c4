"""The two views of a shape: its rigid bodies and the nodes of its hierarchy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.core.edge_labels import carriers_of
from kinmo.core.joint import Joint
from kinmo.features.candidate_features import Evidence
from kinmo.features.prepared_shape import PreparedShape, units_of
from kinmo.methods.kinmo.ranking.ranking_batches import View, hash_words, hypothesis_costs, soft_target


def maximal_nodes(prepared: PreparedShape, leaves: Sequence[int]) -> list[int]:
    """The highest nodes whose leaves all are among `leaves` (positions in `prepared.leaves`)."""
    wanted = set(leaves)
    inside = [set(below) <= wanted for below in prepared.leaves_below]
    return [n for n, parent in enumerate(prepared.parents) if inside[n] and (parent < 0 or not inside[parent])]


def words_of(prepared: PreparedShape, leaves: Sequence[int]) -> tuple[int, ...]:
    """Hashed words that name a unit: its highest nodes, its leaves, and what they are in."""
    top = maximal_nodes(prepared, leaves)
    words = [w for n in top for w in hash_words("part", prepared.part_names[n])]
    words += [w for leaf in leaves for w in hash_words("leaf", prepared.part_names[prepared.leaves[leaf]])]
    above = {prepared.parents[n] for n in top if prepared.parents[n] > 0}
    words += [w for n in sorted(above) for w in hash_words("inside", prepared.part_names[n])]
    return tuple(words)


def category_words(prepared: PreparedShape) -> tuple[int, ...]:
    """Hashed words of the shape's category."""
    return tuple(hash_words("category", prepared.category))


def body_view(prepared: PreparedShape, evidence: Evidence) -> View:
    """*Parts given*: one unit a body of the annotation, in its order. Raises ValueError for a shape without one."""
    if prepared.mobility is None:
        raise ValueError(f"shape {prepared.id} is not annotated")
    joints = [body.joint for body in prepared.mobility.bodies]
    return _view(prepared, evidence, prepared.body_leaves, joints, is_bodies=True)


def node_view(prepared: PreparedShape, evidence: Evidence) -> View:
    """*Hierarchy given*: one unit a node below the root, in preorder."""
    joints: list[Joint | None] = [None] * (len(prepared.parents) - 1)
    if prepared.mobility is not None:
        leaf_sets = [tuple(prepared.leaves[p] for p in below) for below in prepared.leaves_below]
        carried = carriers_of(leaf_sets, prepared.mobility)
        for node in range(1, len(prepared.parents)):
            carrier = carried[node]
            if carrier is not None and carried[prepared.parents[node]] != carrier:
                joints[node - 1] = prepared.mobility.bodies[carrier].joint
    return _view(prepared, evidence, prepared.leaves_below[1:], joints, is_bodies=False)


def _view(
    prepared: PreparedShape,
    evidence: Evidence,
    leaves: Sequence[tuple[int, ...]],
    joints: Sequence[Joint | None],
    *,
    is_bodies: bool,
) -> View:
    index = {each: unit for unit, each in enumerate(units_of(prepared.leaves_below, prepared.body_leaves))}
    units = tuple(index[each] for each in leaves)
    targets = tuple(_target(evidence, unit, joint) for unit, joint in zip(units, joints, strict=True))
    words = tuple(words_of(prepared, each) for each in leaves)
    return View(prepared.id, evidence, units, is_bodies, words, targets, category_words(prepared))


def _target(evidence: Evidence, unit: int, joint: Joint | None) -> NDArray[np.float64] | None:
    if joint is None:
        return None
    return soft_target(hypothesis_costs(evidence, evidence.rows(unit), joint, evidence.centers[unit]))
