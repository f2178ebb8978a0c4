"""Fronts of furniture: where they lie on a carcass, and that they leave room for each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synth_objects import bounds_of

from kinmo.synth.details.casework import add_door_pair
from kinmo.synth.details.casework_filling import bordered
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import open_box
from kinmo.synth.synth_object import Link, Node

OPENING = Opening(0.0, 0.0, 1.0, 0.8, 0.5, 0.0, border=(0.02, 0.01, 0.02, 0.0))
seeds = st.integers(0, 2**32 - 1)


def fronts(gap: float) -> Fronts:
    return Fronts(0.02, gap, 0.002, "plain", has_handles=False, handle_length=0.1)


@pytest.mark.parametrize("gap", [0.0, 0.01])
def test_an_inset_front_keeps_its_gap_to_the_hole(gap: float) -> None:
    face = fronts(gap).face(OPENING)
    assert (face.x, face.y, face.width, face.height) == (0.0, 0.0, 1.0 - 2 * gap, 0.8 - 2 * gap)
    assert fronts(gap).back_plane(OPENING) == pytest.approx(-0.02)


def test_an_overlapping_front_covers_its_border_up_to_the_reveal() -> None:
    face = fronts(-0.02).face(OPENING)
    assert (face.x - face.width / 2, face.x + face.width / 2) == pytest.approx((-0.518, 0.508))
    assert (face.low, face.high) == pytest.approx((-0.418, 0.398))
    assert fronts(-0.02).back_plane(OPENING) == 0.0
    narrow = fronts(-0.005).face(OPENING)
    assert narrow.x - narrow.width / 2 == pytest.approx(-0.505)


@settings(max_examples=60)
@given(seeds)
def test_the_doors_of_a_pair_do_not_overlap(seed: int) -> None:
    draw = Draw(np.random.default_rng(seed))
    root = Node("cabinet")
    base = Link("frame", [root.add("frame", open_box((-0.55, -0.45, -0.55), (0.55, 0.45, 0.0), 0.05))])
    left, right = add_door_pair(draw, root, base, OPENING, Fronts.random(draw, 0.02))
    panels = [next(leaf.pieces for leaf in link.leaves() if leaf.name == "cabinet_door_surface") for link in (left, right)]
    assert bounds_of(panels[0])[1][0] < bounds_of(panels[1])[0][0] + 1e-9


@settings(max_examples=60)
@given(seeds)
def test_rows_without_boards_between_them_do_not_overlap(seed: int) -> None:
    style = Fronts.random(Draw(np.random.default_rng(seed)), 0.02)
    rows = [Opening(0.0, y, 1.0, 0.4, 0.5, 0.0) for y in (-0.2, 0.2)]
    below, above = (
        style.face(bordered(row, 0.02, 0.0, True, True, is_lowest=index == 0, is_highest=index == 1))
        for index, row in enumerate(rows)
    )
    assert below.high < above.low + 1e-9
