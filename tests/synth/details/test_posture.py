"""Postures: turning an object moves its joints along and keeps its size."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kinmo.synth.details.posture import lay_down, turn_about_up
from kinmo.synth.draw import Draw
from kinmo.synth.families import family_builder
from kinmo.synth.primitives.transforms import rotation_about
from kinmo.synth.synth_object import SynthObject


def scissors(seed: int) -> SynthObject:
    shape = family_builder("scissors")(Draw(np.random.default_rng(seed)))
    shape.apply_rest_pose()
    return shape


def corners(shape: SynthObject) -> np.ndarray:
    return np.concatenate([piece.vertices for leaf in shape.root.leaves() for piece in leaf.pieces])


@settings(max_examples=50)
@given(st.integers(0, 1000), st.floats(-180, 180))
def test_moving_an_object_moves_its_joints(seed: int, degrees: float) -> None:
    shape = scissors(seed)
    link = next(link for link in shape.links if link.motion is not None)
    before = link.motion
    matrix = rotation_about((0.3, 1.0, -0.2), degrees, (0.5, 0.1, -0.4))
    still = corners(shape)
    shape.move(matrix)
    after = link.motion
    assert np.allclose(corners(shape), still @ matrix[:3, :3].T + matrix[:3, 3])
    # Moving the joint and then the object equals moving the object and then the joint.
    assert np.allclose(matrix @ before.at(17.0), after.at(17.0) @ matrix)


@settings(max_examples=50)
@given(st.integers(0, 1000))
def test_postures_keep_lengths(seed: int) -> None:
    shape = scissors(seed)
    before = np.sort(np.ptp(corners(shape), axis=0))
    draw = Draw(np.random.default_rng(seed))
    lay_down(draw, shape)
    turn_about_up(draw, shape)
    assert np.allclose(np.sort(np.ptp(corners(shape), axis=0)), before)
