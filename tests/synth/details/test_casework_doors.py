"""Doors of furniture: sliding doors stay in their opening, and folding doors, bins and roll tops open outwards."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from synth_objects import bounds_of, link_pieces, link_vertices

from kinmo.synth.details.casework_doors import (
    add_folding_door,
    add_roll_top,
    add_shutter,
    add_sliding_doors,
    add_tipping_bin,
)
from kinmo.synth.details.casework_extras import add_larder, add_trim
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import open_box
from kinmo.synth.synth_object import Link, Node

seeds = st.integers(0, 2**32 - 1)
OPENING = Opening(0.0, 0.0, 1.0, 0.8, 0.5, 0.0)


def carcass() -> tuple[Node, Link]:
    root = Node("cabinet")
    return root, Link("frame", [root.add("frame", open_box((-0.55, -0.45, -0.55), (0.55, 0.45, 0.0), 0.05))])


@settings(max_examples=60)
@given(seeds)
def test_sliding_doors_stay_in_their_opening(seed: int) -> None:
    root, base = carcass()
    for link in add_sliding_doors(Draw(np.random.default_rng(seed)), root, base, OPENING, 0.02):
        assert link.motion is not None
        panel = [p for leaf in link.leaves() if leaf.name != "handle" for p in leaf.pieces]
        for value in (link.motion.a, link.motion.b):
            low, high = (corner + value * link.motion.direction for corner in bounds_of(panel))
            assert np.all(low[:2] > (-0.501, -0.401)) and np.all(high[:2] < (0.501, 0.401))


@settings(max_examples=40)
@given(seeds)
def test_both_leaves_of_a_folding_door_open_outwards(seed: int) -> None:
    root, base = carcass()
    draw = Draw(np.random.default_rng(seed))
    first, second = add_folding_door(draw, root, base, OPENING, Fronts.random(draw, 0.02))
    assert first.parent is base and second.parent is first
    for link in (first, second):
        assert link.motion is not None
        middle = np.mean(bounds_of(link_pieces(link)), axis=0)
        opened = link.motion.at(0.4 * link.motion.b) @ np.append(middle, 1.0)
        assert opened[2] > middle[2]


@settings(max_examples=40)
@given(seeds)
def test_bins_tip_outwards(seed: int) -> None:
    root, base = carcass()
    draw = Draw(np.random.default_rng(seed))
    link = add_tipping_bin(draw, root, base, OPENING, Fronts.random(draw, 0.02))
    assert link.motion is not None and link.motion.b <= 50.0
    top = max(link_vertices(link), key=lambda vertex: vertex[1])
    opened = link.motion.at(link.motion.b) @ np.append(top, 1.0)
    assert opened[2] > top[2]


@settings(max_examples=40)
@given(seeds)
def test_roll_tops_turn_up_over_their_table(seed: int) -> None:
    root, base = carcass()
    link = add_roll_top(Draw(np.random.default_rng(seed)), root, base, 0.5, 0.0, -0.4, 0.5)
    assert link.motion is not None
    front = link_pieces(link)[0].vertices.mean(axis=0)
    opened = link.motion.at(link.motion.b) @ np.append(front, 1.0)
    assert opened[1] > front[1] + 0.2 and opened[2] < front[2]


@settings(max_examples=40)
@given(seeds)
def test_shutters_cover_their_opening_and_slide_off_it(seed: int) -> None:
    root, base = carcass()
    link = add_shutter(Draw(np.random.default_rng(seed)), root, base, OPENING, 0.02)
    assert link.motion is not None and not link.motion.is_hinge
    panel = [p for leaf in link.leaves() if leaf.name != "handle" for p in leaf.pieces]
    low, high = bounds_of(panel)
    assert np.all(low[:2] < (-0.4, -0.3)) and np.all(high[:2] > (0.4, 0.3))
    shift = link.motion.b * link.motion.direction
    assert np.abs(shift[2]) < 1e-9 and np.linalg.norm(shift) > 0.4


@settings(max_examples=40)
@given(seeds)
def test_the_shelves_of_a_larder_come_out_with_its_front(seed: int) -> None:
    root, base = carcass()
    draw = Draw(np.random.default_rng(seed))
    link = add_larder(draw, root, base, OPENING, Fronts.random(draw, 0.02))
    assert link.motion is not None
    low, high = bounds_of(link_pieces(link))
    assert np.all(low > (-0.6, -0.5, -0.55)) and high[2] < 0.6
    assert link.motion.direction[2] == 1.0 and 0.3 * (0.0 - low[2]) < link.motion.b


@settings(max_examples=40)
@given(seeds)
def test_trim_belongs_to_its_carcass(seed: int) -> None:
    root, base = carcass()
    add_trim(Draw(np.random.default_rng(seed)), root, base, (-0.55, -0.45, -0.55), (0.55, 0.45, 0.0))
    assert set(base.nodes) == set(root.children) and len(base.nodes) > 1
