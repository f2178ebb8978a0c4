"""Wheels and casters: wheels stand on the floor, roll about their middle, and forks swivel about their stem."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from synth_objects import axis_distances, bounds_of, link_pieces, link_vertices

from kinmo.synth.details.wheels import add_caster, wheel_pieces
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box
from kinmo.synth.synth_object import Link, Node

seeds = st.integers(0, 2**32 - 1)
RADIUS, THICK, DROP = 0.1, 0.06, 0.25


def draw(seed: int) -> Draw:
    return Draw(np.random.default_rng(seed))


@settings(max_examples=60)
@given(seeds)
def test_a_wheel_is_round_about_x(seed: int) -> None:
    low, high = bounds_of(wheel_pieces(draw(seed), RADIUS, THICK))
    assert np.allclose(high[1:], -low[1:], rtol=0.08)
    assert 0.9 * RADIUS < high[1] < 1.01 * RADIUS
    assert np.isclose(high[0], -low[0])


@settings(max_examples=60)
@given(seeds, st.floats(0.0, 360.0), st.booleans(), st.booleans())
def test_a_caster_stands_on_the_floor_and_moves_as_asked(seed: int, heading: float, swivels: bool, rolls: bool) -> None:
    root = Node("cart")
    base = Link("body", [root.add("body", box((1, 0.1, 1), (0, DROP + 0.05, 0)))])
    stem = (0.3, DROP, -0.2)
    made = add_caster(draw(seed), root, base, stem, DROP, RADIUS, THICK, heading=heading, swivels=swivels, rolls=rolls)
    assert [link.name for link in made] == ["caster"] * swivels + ["wheel"] * rolls
    owned = [leaf for link in (base, *made) for leaf in link.leaves()]
    assert set(owned) == set(root.leaves()) and len(owned) == len(set(owned))
    pieces = [piece for leaf in root.leaves() for piece in leaf.pieces]
    assert abs(bounds_of(pieces)[0][1]) < 0.1 * RADIUS
    for link in made:
        assert link.motion is not None and link.motion.no_limit
        if link.name == "caster":
            np.testing.assert_allclose(link.motion.origin, stem)
            assert abs(link.motion.direction[1]) > 0.999
        else:
            middle = np.mean(bounds_of(link_pieces(link)), axis=0)
            np.testing.assert_allclose(link.motion.origin, middle, atol=0.05 * RADIUS)
            assert axis_distances(link_vertices(link), link).max() < 1.01 * RADIUS
