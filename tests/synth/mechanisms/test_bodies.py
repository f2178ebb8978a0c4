"""Bodies that carry mechanisms: they are sound, and their parts move in the directions that are free."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
from synth_objects import link_vertices

from kinmo.synth.draw import Draw
from kinmo.synth.families.mechanism import build
from kinmo.synth.mechanisms.hollow import hollow
from kinmo.synth.mechanisms.slab import slab
from kinmo.synth.mechanisms.slender import slender
from kinmo.synth.mechanisms.turning import treadle
from kinmo.synth.primitives import Y
from kinmo.synth.synth_object import SynthObject

SEEDS = 40
LIDS = ("lid", "cover", "cap", "closure")


def box_grid(points: np.ndarray) -> np.ndarray:
    """Points [343, 3] of the box around `points`."""
    shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 7)] * 3), axis=-1).reshape(-1, 3)
    return points.min(axis=0) + shares * np.ptp(points, axis=0)


def objects_of(style: Callable[[Draw, bool], SynthObject]) -> list[SynthObject]:
    return [style(Draw(np.random.default_rng(seed)), seed % 2 == 0) for seed in range(SEEDS)]


@pytest.mark.parametrize("style", [hollow, slender, slab], ids=lambda style: style.__name__)
def test_a_body_and_its_mechanisms_are_sound(style: Callable[[Draw, bool], SynthObject]) -> None:
    for made in objects_of(style):
        made.check()
        body, *moving = made.links
        assert body.motion is None and moving
        size = np.linalg.norm(np.ptp(np.concatenate([link_vertices(link) for link in made.links]), axis=0))
        for link in moving:
            assert link.motion is not None and link.parent in made.links
            points = link_vertices(link)
            if link.motion.has_position:
                offsets = box_grid(points) - link.motion.origin
                across = offsets - np.outer(offsets @ link.motion.direction, link.motion.direction)
                assert np.linalg.norm(across, axis=1).min() < 0.1 * size, (link.name, link.motion)
            body_points = link_vertices(body)
            gap = np.maximum(points.min(axis=0) - body_points.max(axis=0), body_points.min(axis=0) - points.max(axis=0))
            assert link.parent is not body or gap.max() < 0.1 * size, f"{link.name} is not at the body"


def test_a_loose_lid_lifts_off_upwards() -> None:
    lifted = 0
    for made in objects_of(hollow):
        for link in made.links[1:]:
            if link.name in LIDS and link.motion is not None and not link.motion.is_hinge:
                assert link.motion.direction @ Y > 0.99 or link.motion.has_position
                lifted += not link.motion.has_position
    assert lifted > 5


def test_a_hinged_lid_opens_upwards_about_a_horizontal_line() -> None:
    opened = 0
    for made in objects_of(hollow):
        for link in made.links[1:]:
            motion = link.motion
            if link.name in LIDS and motion is not None and motion.is_hinge and not motion.no_limit:
                assert abs(motion.direction @ Y) < 1e-9
                far = link_vertices(link)[np.argmax(np.linalg.norm(link_vertices(link) - motion.origin, axis=1))]
                turned = motion.at(0.5 * (motion.a + motion.b)) @ np.append(far, 1.0)
                assert turned[1] > far[1]
                opened += 1
    assert opened > 3


def test_slender_bodies_move_along_or_about_their_own_axes() -> None:
    for made in objects_of(slender):
        for link in made.links[1:]:
            assert link.motion is not None
            assert np.isclose(np.abs(link.motion.direction).max(), 1.0)


def test_the_keys_of_a_slab_move_into_it_and_do_not_overlap() -> None:
    keyboards = 0
    for made in objects_of(slab):
        plate = next(iter(made.links[0].leaves())).pieces[0].vertices
        middle = 0.5 * (plate.min(axis=0) + plate.max(axis=0))
        keys = [link for link in made.links if link.motion and not link.motion.has_position and link.motion.b == 0.0]
        keyboards += bool(keys)
        for key in keys:
            assert key.motion is not None
            pressed = key.motion.direction * key.motion.a
            center = link_vertices(key).mean(axis=0)
            outward = (center - middle) @ key.motion.direction * key.motion.direction
            assert pressed @ outward < 0.0
        boxes = [(link_vertices(key).min(axis=0), link_vertices(key).max(axis=0)) for key in keys[:20]]
        for (low, high), (other_low, other_high) in combinations(boxes, 2):
            assert (np.minimum(high, other_high) - np.maximum(low, other_low)).min() < 1e-9
    assert keyboards > 0.6 * SEEDS


def test_tipping_pads_go_down_at_the_end_away_from_their_axis() -> None:
    for seed in range(SEEDS):
        for pad in treadle(Draw(np.random.default_rng(seed))).moving:
            points = np.concatenate([piece.vertices for piece in pad.pieces])
            free = points[np.argmin(points[:, 1])]
            pressed = pad.motion.at(pad.motion.b) @ np.append(free, 1.0)
            assert pressed[2] < free[2] - 0.01


def test_nearly_all_wheels_roll_about_a_horizontal_line() -> None:
    wheels = [
        link
        for seed in range(4 * SEEDS)
        for link in build(Draw(np.random.default_rng(seed))).links
        if link.name == "wheel" and link.motion is not None
    ]
    assert len(wheels) > 10
    # Blocks that are laid on another side take their wheels along.
    assert np.mean([abs(link.motion.direction @ Y) <= 0.7 for link in wheels if link.motion is not None]) > 0.95


def test_wings_fold_in_over_their_body() -> None:
    folded = 0
    for made in objects_of(slender):
        wings = [link for link in made.links if link.name == "wing" and link.motion is not None]
        for wing in wings:
            assert wing.motion is not None
            middle = link_vertices(made.links[0]).mean(axis=0)
            far = link_vertices(wing)[np.argmax(np.linalg.norm(link_vertices(wing) - wing.motion.origin, axis=1))]
            closed = (wing.motion.at(wing.motion.b) @ np.append(far, 1.0))[:3]
            inwards = middle - wing.motion.origin
            assert (closed - wing.motion.origin) @ inwards > 0.0
            folded += 1
    assert folded > 3


def test_node_names_that_state_a_motion_are_correct() -> None:
    stated = 0
    for seed in range(4 * SEEDS):
        for link in build(Draw(np.random.default_rng(seed))).links[1:]:
            words = link.nodes[0].name.split("_")
            if link.motion is not None and words[0] in ("rotation", "translation"):
                assert not link.motion.rotates
                assert link.motion.is_hinge == (words[0] == "rotation")
                stated += 1
    assert stated > 10
