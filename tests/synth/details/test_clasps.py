"""Clasps, carrying handles and door locks: their joints fit their shape."""

from __future__ import annotations

import numpy as np
import pytest

from kinmo.core.shape import Mesh
from kinmo.synth.details.carrying_handles import add_carrying_handle
from kinmo.synth.details.clasps import add_clasp, random_clasp
from kinmo.synth.details.door_locks import LOCK_NAMES, add_door_lock
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import X, Y, Z, box, transform
from kinmo.synth.primitives.transforms import facing
from kinmo.synth.synth_object import Link, Motion, Node

SEEDS = range(60)


def draws(seed: int) -> Draw:
    return Draw(np.random.default_rng(seed))


def carrier(name: str) -> Link:
    return Link(name, [Node(name, pieces=[box((1, 1, 1))])])


def at_end(pieces: list[Mesh], motion: Motion) -> np.ndarray:
    return np.concatenate([transform(piece, motion.at(motion.b)).vertices for piece in pieces])


def test_clasps_move_off_the_wall_or_along_it() -> None:
    for seed in SEEDS:
        for pieces, motion in random_clasp(draws(seed), 0.2).moving:
            before = np.concatenate([piece.vertices for piece in pieces])
            after = at_end(pieces, motion)
            if motion.is_hinge and abs(motion.direction[2]) < 0.5 and not motion.no_limit:
                assert after[:, 2].mean() > before[:, 2].mean() - 0.02
            assert np.abs(after).max() < 1.0


def test_a_placed_clasp_is_the_same_clasp_elsewhere() -> None:
    place = facing(Y, Z, (0.3, 0.5, 0.1))
    for seed in SEEDS:
        clasp = random_clasp(draws(seed), 0.2)
        links = add_clasp(draws(seed), Node("root"), carrier("body"), carrier("lid"), place, 0.2)
        assert len(links) == len(clasp.moving)
        for link, (pieces, motion) in zip(links, clasp.moving, strict=True):
            assert link.parent is not None and link.parent.name == ("lid" if clasp.on_lid else "body")
            assert link.motion is not None
            moved = at_end([leaf for node in link.nodes for leaf in node.pieces], link.motion)
            expected = at_end(pieces, motion) @ place[:3, :3].T + place[:3, 3]
            np.testing.assert_allclose(moved, expected, atol=1e-9)


def test_hanging_handles_lie_against_their_wall() -> None:
    for seed in SEEDS:
        owner = carrier("body")
        links = add_carrying_handle(draws(seed), Node("root"), owner, facing(X, Y, (1.0, 0.0, 0.0)), 0.2, hangs=True)
        motion = links[0].motion
        assert motion is not None
        hanging = np.concatenate([transform(piece, motion.at(90.0)).vertices for piece in links[0].nodes[0].pieces])
        assert hanging[:, 1].mean() < 0.0
        assert hanging[:, 0].max() < 1.1


def test_a_fixed_handle_belongs_to_its_carrier_in_its_hanging_pose() -> None:
    for seed in SEEDS:
        owner = carrier("body")
        assert add_carrying_handle(draws(seed), Node("root"), owner, np.eye(4), 0.2, hangs=True, movable=False) == []
        assert len(owner.nodes) == 2
        assert np.mean([piece.vertices[:, 1].mean() for piece in owner.nodes[1].pieces]) < 0.0


@pytest.mark.parametrize("kind", LOCK_NAMES)
def test_door_locks_turn_about_the_doors_normal_at_their_foot(kind: str) -> None:
    for seed in range(20):
        link = add_door_lock(draws(seed), Node("root"), carrier("door"), kind, (0.2, 0.3, 0.5), 0.1)
        assert link.motion is not None
        np.testing.assert_allclose(link.motion.direction, Z)
        np.testing.assert_allclose(link.motion.origin[:2], (0.2, 0.3))
        low = np.min([piece.vertices.min(axis=0) for piece in link.nodes[0].pieces], axis=0)
        assert low[2] > 0.5 - 1e-6
