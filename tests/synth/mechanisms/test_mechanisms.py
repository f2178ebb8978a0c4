"""Mechanisms: their parts are at their joints and move as stated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinmo.synth.draw import Draw
from kinmo.synth.mechanisms import MECHANISMS, STRETCHABLE, MechanismBuilder, MovingPart
from kinmo.synth.mechanisms.covers import folding_panels, hatch, hatch_pair, tipping_bin
from kinmo.synth.mechanisms.fronts import INTERIORS
from kinmo.synth.mechanisms.mechanism_model import Mechanism
from kinmo.synth.mechanisms.mount import DOOR_NAMES, LID_NAMES, mount
from kinmo.synth.primitives import X, Y, Z, box, scale, transform
from kinmo.synth.synth_object import Link, Node, hinge, slider

BUILDERS = sorted(set(MECHANISMS), key=lambda builder: builder.__name__)
SEEDS = 25


def points_of(part: MovingPart) -> np.ndarray:
    return np.concatenate([piece.vertices for piece in part.pieces])


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda builder: builder.__name__)
def test_a_mechanism_stands_on_its_mount(builder: MechanismBuilder) -> None:
    """Some pieces reach the plane z = 0, most are above it, and all are within a few cells."""
    for seed in range(SEEDS):
        mechanism = builder(Draw(np.random.default_rng(seed)))
        pieces = [*mechanism.fixed, *(piece for part in mechanism.moving for piece in part.pieces)]
        points = np.concatenate([piece.vertices for piece in pieces])
        assert np.isfinite(points).all()
        assert points[:, 2].min() < 0.1
        assert np.median(points[:, 2]) > -0.05
        assert np.abs(points[:, :2]).max() < 2.5


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda builder: builder.__name__)
def test_an_axis_passes_near_its_part(builder: MechanismBuilder) -> None:
    for seed in range(SEEDS):
        for part in builder(Draw(np.random.default_rng(seed))).moving:
            motion = part.motion
            assert np.isclose(np.linalg.norm(motion.direction), 1.0)
            assert motion.no_limit or motion.a < motion.b
            if motion.has_position:
                offsets = points_of(part) - motion.origin
                across = np.linalg.norm(offsets - np.outer(offsets @ motion.direction, motion.direction), axis=1)
                assert across.min() < 0.5 * np.linalg.norm(np.ptp(points_of(part), axis=0)), builder.__name__


@pytest.mark.parametrize("builder", BUILDERS, ids=lambda builder: builder.__name__)
def test_parents_come_before_their_children(builder: MechanismBuilder) -> None:
    for seed in range(SEEDS):
        seen: list[MovingPart] = []
        for part in builder(Draw(np.random.default_rng(seed))).moving:
            assert part.parent is None or part.parent in seen
            seen.append(part)


@pytest.mark.parametrize("builder", [hatch, hatch_pair, folding_panels, tipping_bin], ids=lambda builder: builder.__name__)
def test_covers_swing_away_from_their_mount(builder: MechanismBuilder) -> None:
    for seed in range(SEEDS):
        for part in builder(Draw(np.random.default_rng(seed))).moving:
            motion = part.motion
            if motion.no_limit or abs(motion.direction @ Z) > 0.9:
                continue
            middle = 0.5 * (points_of(part).min(axis=0) + points_of(part).max(axis=0))
            opened = motion.at(0.5 * motion.b) @ np.append(middle, 1.0)
            assert opened[2] > middle[2]


@given(st.sampled_from(sorted(set(STRETCHABLE), key=lambda builder: builder.__name__)), st.integers(0, 1000))
def test_stretchable_mechanisms_move_along_axes_of_their_cell(builder: MechanismBuilder, seed: int) -> None:
    for part in builder(Draw(np.random.default_rng(seed))).moving:
        assert np.isclose(np.abs(part.motion.direction).max(), 1.0)


@pytest.mark.parametrize(("direction", "names"), [(Y, DOOR_NAMES), (-Y, DOOR_NAMES), (X, LID_NAMES), (Z, LID_NAMES)])
def test_most_panel_names_fit_the_direction_of_the_hinge(direction: np.ndarray, names: tuple[str, ...]) -> None:
    draw = Draw(np.random.default_rng(3))
    names_given = []
    for _ in range(200):
        panel = MovingPart(draw.pick([*DOOR_NAMES, *LID_NAMES]), [box((1, 1, 0.1))], hinge((0, 0, 0), direction, 0.0, 90.0))
        names_given += [link.name for link in mount(draw, Mechanism([panel]), 1.0, np.eye(4), Node("group"), Link("base", []))]
    assert 0.8 < np.mean([name in names for name in names_given]) < 1.0


@pytest.mark.parametrize("builder", INTERIORS, ids=lambda builder: builder.__name__)
def test_interiors_fit_behind_their_door(builder: Callable[[Draw, float, float, float], Mechanism]) -> None:
    for seed in range(SEEDS):
        draw = Draw(np.random.default_rng(seed))
        size = np.array([draw.between(0.3, 1.0) for _ in range(3)])
        for part in builder(draw, *size).moving:
            low, high = points_of(part).min(axis=0), points_of(part).max(axis=0)
            assert (low >= -size * (0.5, 0.6, 1.0) - 1e-9).all() and (high <= size * (0.5, 0.5, 0.0) + 1e-9).all()


@given(st.sampled_from([X, Y, Z]), st.lists(st.floats(0.2, 3.0), min_size=3, max_size=3), st.floats(-1.0, 1.0))
def test_a_stretched_slider_moves_the_stretched_part_alike(axis: np.ndarray, factors: list[float], share: float) -> None:
    motion, part = slider(axis, -1.0, 1.0), box((0.3, 0.2, 0.1), (0.1, 0.2, 0.3))
    moved_then_stretched = scale(transform(part, motion.at(share)), factors)
    stretched = motion.scaled(factors)
    stretched_then_moved = transform(scale(part, factors), stretched.at(share * stretched.b))
    assert np.allclose(moved_then_stretched.vertices, stretched_then_moved.vertices)


@given(st.floats(0.2, 3.0), st.floats(-180.0, 180.0))
def test_a_scaled_hinge_turns_the_scaled_part_alike(factor: float, degrees: float) -> None:
    motion, part = hinge((0.3, -0.2, 0.1), (0.6, 0.0, 0.8), -180.0, 180.0), box((0.3, 0.2, 0.1))
    moved_then_scaled = scale(transform(part, motion.at(degrees)), factor)
    scaled_then_moved = transform(scale(part, factor), motion.scaled(factor).at(degrees))
    assert np.allclose(moved_then_scaled.vertices, scaled_then_moved.vertices)
