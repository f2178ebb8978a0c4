"""The two views of a shape: its rigid bodies and the nodes of its hierarchy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo.evidence import Evidence
from kinmo.ground_truth import carriers_of
from kinmo.joint import Joint
from kinmo.learning.joint_ranking.data import View, hash_words, hypothesis_costs, soft_target
from kinmo.prepared import PreparedShape


def maximal_nodes(prepared: PreparedShape, leaves: Sequence[int]) -> list[int]:
    """The highest nodes whose leaves all are among `leaves` (positions in `prepared.leaves`)."""
    wanted = set(leaves)
    inside = [set(below) <= wanted for below in prepared.leaves_below]
    return [n for n, parent in enumerate(prepared.parents) if inside[n] and (parent < 0 or not inside[parent])]


def words_of(prepared: PreparedShape, leaves: Sequence[int]) -> tuple[int, ...]:
    """Hashed words that name a unit: its highest nodes, its leaves, its surroundings, and the shape's category."""
    top = maximal_nodes(prepared, leaves)
    words = [w for n in top for w in hash_words("part", prepared.part_names[n])]
    words += [w for leaf in leaves for w in hash_words("leaf", prepared.part_names[prepared.leaves[leaf]])]
    above = {prepared.parents[n] for n in top if prepared.parents[n] > 0}
    words += [w for n in sorted(above) for w in hash_words("inside", prepared.part_names[n])]
    return tuple(words + hash_words("category", prepared.category))


def _target(evidence: Evidence, unit: int, joint: Joint | None) -> NDArray[np.float64] | None:
    if joint is None:
        return None
    rows = slice(int(evidence.offsets[unit]), int(evidence.offsets[unit + 1]))
    return soft_target(hypothesis_costs(evidence, rows, joint, evidence.centers[unit]))


def unit_leaves(prepared: PreparedShape) -> tuple[tuple[int, ...], ...]:
    """The distinct sets of leaves (positions) that are a node below the root or a body, nodes first."""
    units = list(dict.fromkeys(prepared.leaves_below[1:]))
    if prepared.mobility is not None:
        position = {leaf: i for i, leaf in enumerate(prepared.leaves)}
        bodies = [tuple(sorted(position[leaf] for leaf in body.leaves)) for body in prepared.mobility.bodies]
        units += [body for body in dict.fromkeys(bodies) if body not in set(units)]
    return tuple(units)


def body_view(prepared: PreparedShape, evidence: Evidence) -> View:
    """*Parts given*: one unit a body of the annotation, in its order."""
    assert prepared.mobility is not None, "only an annotated shape has bodies"
    index = {leaves: i for i, leaves in enumerate(unit_leaves(prepared))}
    position = {leaf: i for i, leaf in enumerate(prepared.leaves)}
    leaves = [tuple(sorted(position[leaf] for leaf in body.leaves)) for body in prepared.mobility.bodies]
    units = tuple(index[each] for each in leaves)
    return View(
        prepared.id,
        evidence,
        units,
        True,
        tuple(words_of(prepared, each) for each in leaves),
        tuple(_target(evidence, u, body.joint) for u, body in zip(units, prepared.mobility.bodies, strict=True)),
    )


def node_view(prepared: PreparedShape, evidence: Evidence) -> View:
    """*Hierarchy given*: one unit a node below the root, in preorder."""
    index = {leaves: i for i, leaves in enumerate(unit_leaves(prepared))}
    nodes = range(1, len(prepared.parents))
    units = tuple(index[prepared.leaves_below[n]] for n in nodes)
    joints: list[Joint | None] = [None] * len(units)
    if prepared.mobility is not None:
        leaf_sets = [tuple(prepared.leaves[p] for p in below) for below in prepared.leaves_below]
        carried = carriers_of(leaf_sets, prepared.mobility)
        for slot, node in enumerate(nodes):
            carrier = carried[node]
            if carrier is not None and carried[prepared.parents[node]] != carrier:
                joints[slot] = prepared.mobility.bodies[carrier].joint
    return View(
        prepared.id,
        evidence,
        units,
        False,
        tuple(words_of(prepared, prepared.leaves_below[n]) for n in nodes),
        tuple(_target(evidence, u, joint) for u, joint in zip(units, joints, strict=True)),
    )
