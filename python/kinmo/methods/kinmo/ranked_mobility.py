"""The `kinmo` method from ranked hypotheses to a mobility tree.

*Parts given*, every body's hypotheses are ranked and the best is its joint. *Hierarchy given*, the nodes are ranked first:
those that rather move than rest become bodies, siblings that the motion GNN holds to be fixed to each other become one, and the
bodies are then ranked like given ones. What type of motion the GNN holds a body to have is taken into account (`type_odds`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.box import are_alike
from kinmo.core.joint import Joint, JointKind, MotionType
from kinmo.core.mobility import Body, descendants
from kinmo.core.prediction import JointEstimate
from kinmo.features.candidate_features import Evidence, Scene, gather
from kinmo.features.candidate_joints import Candidates
from kinmo.features.free_travel import free_travel
from kinmo.features.part_geometry import symmetric_box
from kinmo.features.prepared_shape import PreparedShape, part_sizes, units_of
from kinmo.features.scene import TOUCHING
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.learning.motion_gnn.gnn_estimate import gnn_joint, mean_estimate
from kinmo.methods.kinmo.gnn_prior import motion_types_of, outward_edges, with_types
from kinmo.methods.kinmo.ranking.joint_ranker import JointRanking
from kinmo.methods.kinmo.ranking.ranked_joints import MOVES, rank_answers, same_joint
from kinmo.methods.kinmo.ranking.ranking_batches import View
from kinmo.methods.kinmo.ranking.shape_views import category_words, node_view, words_of

F64 = NDArray[np.float64]

CONTACT_SCALE = 0.01
FIXED = 0.5
"""Moving siblings are one body if the GNN's mean probability of FIXED between them is above this."""
LARGE = 0.03
"""Of the surface of a shape: that a smaller part, a pin of a hinge or a button, moves after all spoils no label."""
OFF_LINE, ALONG_LINE = 0.02, 0.9
"""How far (diagonals) a shaft's middle may be from the line it turns about, and the least cosine between that and its own."""


def ranked_bodies(
    shape: PreparedShape,
    meshes: _core.Meshes | None,
    bodies: Sequence[tuple[int, ...]],
    ranking: JointRanking,
    edges: EdgePredictions,
    *,
    rests: Literal["any", "first", "one"] = "any",
    kinds: Sequence[JointKind | None] | None = None,
) -> list[tuple[JointEstimate, ...]]:
    """Ranked answers for every body (positions of its leaves), in the normalised frame, without limits.

    `rests` says which bodies may rest: any; the first, which does (it has been decided already that the others move; if it is
    empty, that does which most likely rests); or one, that which most likely does (bodies of one shape are fastened to each
    other, so that but one need rest). `kinds` says how bodies move
    (None: that is asked). `meshes` (of the leaves, in the normalised frame) are needed for bodies that `shape` was not
    prepared with; without them those raise ValueError. `edges` are what the motion GNN says.
    """
    wanted = [body for body in bodies if body]
    evidence, place = _evidence_of(shape, meshes, wanted)
    words = tuple(words_of(shape, leaves) for leaves in wanted)
    asked = tuple(place[body] for body in wanted)
    view = View(shape.id, evidence, asked, True, words, (None,) * len(wanted), category_words(shape))
    probabilities, rest = ranking.probabilities(view)
    said = {body: (odds, float(still)) for body, odds, still in zip(wanted, probabilities, rest, strict=True)}
    stillest = wanted[int(np.argmax(rest))]
    base = bodies[0] or stillest
    resting = {"any": set(wanted), "first": {base}, "one": {stillest}}[rests]
    answers: list[tuple[JointEstimate, ...]] = []
    for index, body in enumerate(bodies):
        if not body:
            answers.append((JointEstimate(None, MotionType.FIXED, 1.0, source="ranking"),))
            continue
        odds, still = said[body]
        box = symmetric_box(shape, body, meshes)
        odds = with_types(odds, motion_types_of(shape, body, edges), evidence, place[body], box, shape.up)
        if still >= MOVES and body not in resting:
            odds, still = odds / odds.sum() * (1.0 - MOVES / 2), MOVES / 2
        if still < MOVES and rests == "first" and body == base:
            odds, still = odds / odds.sum() * (1.0 - MOVES), MOVES
        kind = None if kinds is None else kinds[index]
        if kind is not None:
            odds = np.where(evidence.kinds[evidence.rows(place[body])] == kind.code, odds, 0.0)
            odds, still = (odds / odds.sum(), 0.0) if odds.any() else (odds, 1.0)
        answers.append(rank_answers(evidence, place[body], odds, still, box, shape.up))
    return answers


def _evidence_of(
    shape: PreparedShape, meshes: _core.Meshes | None, bodies: Sequence[tuple[int, ...]]
) -> tuple[Evidence, dict[tuple[int, ...], int]]:
    """Evidence for some bodies, and which unit of it each is; what `shape` was prepared with is not looked at again."""
    known = Evidence.of(shape.evidence) if shape.evidence else None
    units = () if known is None else units_of(shape.leaves_below, shape.body_leaves)
    place = {leaves: unit for unit, leaves in enumerate(units)}
    others = [body for body in dict.fromkeys(bodies) if body not in place]
    # evidence may have more units: those of bodies of an annotation that was taken from the shape
    place |= {leaves: unit for unit, leaves in enumerate(others, start=0 if known is None else len(known))}
    if known is not None and not others:
        return known, place
    if meshes is None:
        raise ValueError("meshes: needed for bodies that the shape was not prepared with")
    gathered = gather(scene_of(shape, meshes), others, part_sizes(shape.leaves_below, shape.minimum_boxes))
    found = Evidence.of(gathered.arrays())  # rounded as what is stored, so that it does not matter which body was
    return found if known is None else known.joined(found), place


def scene_of(shape: PreparedShape, meshes: _core.Meshes) -> Scene:
    """The scene that `shape` was prepared from."""
    return Scene.of(meshes, shape.leaf_points, shape.leaf_normals, shape.leaf_areas, shape.up)


@dataclass(frozen=True, eq=False)
class SaidNodes:
    """The nodes that move, each with its best joint (normalised frame), and `doubt`: the largest chance that one of those
    moves that are said to rest, of nodes with at least the share `LARGE` of the surface that neither are part of a moving one
    nor have one below them.
    """

    moving: Mapping[int, Joint]
    doubt: float


def moving_nodes(shape: PreparedShape, ranking: JointRanking, edges: EdgePredictions) -> SaidNodes:
    """The nodes that rather move against their surroundings than rest, which the ranking decides alone.

    In how they move the motion GNN has a word: `edges` are its answers. A node with the same joint as the moving node that it
    is in moves with that, not against it.
    """
    if len(shape.parents) < 2:
        return SaidNodes({}, 0.0)
    evidence = Evidence.of(shape.evidence)
    view = node_view(replace(shape, mobility=None), evidence)
    probabilities, rest = ranking.probabilities(view)
    moving: dict[int, Joint] = {}
    for node, (unit, odds, still) in enumerate(zip(view.units, probabilities, rest, strict=True), start=1):
        if still < MOVES:
            box = shape.symmetric_boxes[node]
            types = motion_types_of(shape, shape.leaves_below[node], edges)
            odds = with_types(odds, types, evidence, unit, box, shape.up)
            best = rank_answers(evidence, unit, odds, float(still), box, shape.up)[0].joint
            assert best is not None, "what rather moves is answered with a joint"
            above = shape.parents[node]
            while above > 0 and above not in moving:
                above = shape.parents[above]
            if above not in moving or not same_joint(moving[above], best):
                moving[node] = best
    return SaidNodes(moving, _doubt(shape, moving, rest))


def _doubt(shape: PreparedShape, moving: Mapping[int, Joint], rest: F64) -> float:
    touched = {other for node in moving for other in (node, *_above(shape, node))}
    least = LARGE * shape.leaf_areas.sum()
    chances = [
        1.0 - float(rest[node - 1])
        for node in range(1, len(shape.parents))
        if node not in touched
        and not moving.keys() & _above(shape, node)
        and shape.leaf_areas[list(shape.leaves_below[node])].sum() >= least
    ]
    return max(chances, default=0.0)


def _above(shape: PreparedShape, node: int) -> set[int]:
    above = set()
    while (node := shape.parents[node]) >= 0:
        above.add(node)
    return above


def predicted_bodies(shape: PreparedShape, moving: Mapping[int, Joint], edges: EdgePredictions) -> list[tuple[int, ...]]:
    """Positions of the leaves of every body; body 0 is what everything rests on (it may be empty).

    Moving siblings are one body if the GNN holds them to be fixed to each other, they touch, and they have the same joint, but
    are not alike: the front and the box of a drawer are, two drawers or the keys of a keypad are not. A shaft needs no word of
    the GNN's: it is one body with what it touches and shares its line with, as a laptop's screen with its hinge.
    """
    fixed, sizes = edges.type_set.FIXED.value, shape.minimum_boxes.half_extents
    shafts = {node for node, joint in moving.items() if is_shaft(shape, node, joint)}
    odds: dict[tuple[int, int], list[float]] = {}
    for (part, other), probability, distance in zip(
        shape.edges.tolist(), edges.type_probabilities[:, fixed], shape.edge_distances, strict=True
    ):
        if part not in moving or other not in moving or distance > TOUCHING or are_alike(sizes[part], sizes[other]):
            continue
        if same_joint(moving[part], moving[other]):
            sure = part in shafts or other in shafts
            odds.setdefault((min(part, other), max(part, other)), []).append(1.0 if sure else float(probability))
    group = {node: node for node in moving}
    for pair, values in odds.items():
        if np.mean(values) > FIXED:
            first, second = sorted(group[node] for node in pair)
            group = {node: first if leader == second else leader for node, leader in group.items()}
    owner = [0] * len(shape.parents)
    for node, parent in enumerate(shape.parents):
        owner[node] = group[node] if node in group else owner[parent] if parent >= 0 else 0
    leaves: dict[int, list[int]] = {leader: [] for leader in (0, *sorted(set(group.values())))}
    for position, leaf in enumerate(shape.leaves):
        leaves[owner[leaf]].append(position)
    return [tuple(below) for leader, below in leaves.items() if below or leader == 0]


def is_shaft(shape: PreparedShape, node: int, joint: Joint) -> bool:
    """Whether a part turns about its own length: its box lies along the line of its joint, the middle on it."""
    boxes = shape.minimum_boxes
    offset = boxes.centers[node] - joint.pivot
    across = np.linalg.norm(offset - (offset @ joint.direction) * joint.direction)
    longest = int(np.argmax(boxes.half_extents[node]))
    along = abs(float(boxes.axes[node, longest] @ joint.direction))
    return joint.kind is JointKind.REVOLUTE and bool(across <= OFF_LINE) and along >= ALONG_LINE


def network_estimates(shape: PreparedShape, bodies: Sequence[tuple[int, ...]], edges: EdgePredictions) -> list[JointEstimate]:
    """What the motion GNN alone says of every body, by the edges from its parts to siblings outside it (normalised frame)."""
    estimates = []
    for leaves in bodies:
        outwards = outward_edges(shape, leaves)
        estimates.append(gnn_joint(mean_estimate(edges, outwards) if len(outwards) else None))
    return estimates


def attached_to(
    shape: PreparedShape, meshes: _core.Meshes, bodies: Sequence[tuple[int, ...]], moves: Sequence[bool]
) -> list[int | None]:
    """What every moving body is attached to: the body it shares most contact with, of those that are not attached to it.

    Bodies that rest are attached to nothing.
    """
    scene = scene_of(shape, meshes)
    affinity = np.full((len(bodies), len(bodies)), -1.0)
    for index, leaves in enumerate(bodies):
        if not moves[index]:
            continue
        points, _ = scene.surface(leaves, 512)
        _, riders = scene.surroundings(leaves)
        others = [place for place, other in enumerate(bodies) if place != index and other and not set(other) <= set(riders)]
        if others:
            gaps = np.array([_core.closest_points(meshes, list(bodies[place]), points)[0] for place in others])
            affinity[index, others] = np.exp(-(gaps - gaps.min()) / CONTACT_SCALE).mean(axis=1)
    parents: list[int | None] = [None] * len(bodies)
    for flat in np.argsort(-affinity, axis=None, kind="stable"):
        index, other = divmod(int(flat), len(bodies))
        if affinity[index, other] < 0:
            break
        if parents[index] is None and other not in descendants(parents, index):
            parents[index] = other
    return parents


def with_limits(
    answers: Sequence[JointEstimate], shape: PreparedShape, meshes: _core.Meshes, moving: Sequence[int]
) -> tuple[JointEstimate, ...]:
    """Ranked answers for one body with the range that it goes, directions turned to the farther side, and the term `sweep`.

    `moving` are the positions of all leaves that move along. The best answer has all probes of a sweep to itself; the others
    share those of one more.
    """
    return (*_limited(answers[:1], shape, meshes, moving), *_limited(answers[1:], shape, meshes, moving))


def _limited(
    answers: Sequence[JointEstimate], shape: PreparedShape, meshes: _core.Meshes, moving: Sequence[int]
) -> list[JointEstimate]:
    """The answers with what one sweep says of them; those without a joint as they are."""
    joints = {place: answer.joint for place, answer in enumerate(answers) if answer.joint is not None}
    limited = list(answers)
    if not joints:
        return limited
    candidates = Candidates(
        np.array([joint.kind.code for joint in joints.values()], np.uint8),
        np.array([joint.direction for joint in joints.values()]),
        np.array([joint.pivot for joint in joints.values()]),
        tuple(answers[place].source for place in joints),
    )
    obstacles = sorted(set(range(len(shape.leaves))) - set(moving))
    points = shape.leaf_points[list(moving)].reshape(-1, 3).astype(np.float64)
    travel = free_travel(meshes, moving, obstacles, candidates, points)
    for row, (place, joint) in enumerate(joints.items()):
        lower, upper = travel.range(row)
        joint = replace(joint, lower=lower, upper=upper)
        if lower is not None and upper is not None and -lower > upper:
            joint = joint.reversed()
        limited[place] = replace(
            answers[place], joint=joint, terms={**answers[place].terms, "sweep": float(travel.freedom[row])}
        )
    return limited


def tree_of(
    shape: PreparedShape,
    meshes: _core.Meshes,
    bodies: Sequence[tuple[int, ...]],
    names: Sequence[str],
    answers: Sequence[tuple[JointEstimate, ...]],
) -> tuple[tuple[Body, ...], list[tuple[JointEstimate, ...]]]:
    """Bodies with parents and the best joints, and all answers with their limits, in the normalised frame."""
    moves = [found[0].joint is not None for found in answers]
    parents = attached_to(shape, meshes, bodies, moves)
    limited = []
    for index, found in enumerate(answers):
        along = sorted(leaf for body in descendants(parents, index) for leaf in bodies[body])
        limited.append(with_limits(found, shape, meshes, along))
    tree = tuple(
        Body(index, name, tuple(shape.leaves[position] for position in leaves), parents[index], found[0].joint)
        for index, (name, leaves, found) in enumerate(zip(names, bodies, limited, strict=True))
    )
    return tree, limited
