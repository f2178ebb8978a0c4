"""Button boxes, hobs, valves and beds: buttons go in, knobs turn about themselves, rails go down, backs fold up."""

from __future__ import annotations

import numpy as np
import pytest
from synth_objects import bounds_of, build_object, link_pieces, moving_links

from kinmo.synth.synth_object import Link

SEEDS = 30


def links(name: str, *wanted: str) -> list[Link]:
    shapes = [build_object(name, seed) for seed in range(SEEDS)]
    return [link for shape in shapes for link in moving_links(shape) if link.name in wanted]


def test_buttons_move_into_their_box() -> None:
    for seed in range(SEEDS):
        shape = build_object("button_box", seed)
        low, high = bounds_of([piece for link in shape.links if link.motion is None for piece in link_pieces(link)])
        for link in moving_links(shape):
            if link.name == "button" and link.motion is not None:
                middle = np.mean(bounds_of(link_pieces(link)), axis=0)
                inwards = 0.5 * (low + high) - middle
                assert inwards @ link.motion.direction > 0.0


def test_boxes_have_buttons_and_levers() -> None:
    assert len(links("button_box", "button")) > 10
    assert len(links("button_box", "lever")) > 10


@pytest.mark.parametrize(("name", "part"), [("hob", "knob"), ("valve", "switch")])
def test_knobs_turn_about_a_line_through_them(name: str, part: str) -> None:
    found = links(name, part)
    assert len(found) >= SEEDS
    for link in found:
        assert link.motion is not None and (link.motion.is_hinge or link.motion.rotates)
        low, high = bounds_of(link_pieces(link))
        assert np.all(link.motion.origin > low - 0.05) and np.all(link.motion.origin < high + 0.05)


def test_hobs_have_two_to_six_knobs() -> None:
    for seed in range(SEEDS):
        count = sum(link.name == "knob" for link in moving_links(build_object("hob", seed)))
        assert 2 <= count <= 6


def test_rails_go_down_and_backs_fold_up() -> None:
    for link in links("bed", "rail", "backrest"):
        assert link.motion is not None
        middle = np.append(np.mean(bounds_of(link_pieces(link)), axis=0), 1.0)
        ends = [(link.motion.at(value) @ middle)[1] for value in (link.motion.a, link.motion.b)]
        assert ends[1] > ends[0] if link.name == "backrest" else ends[1] < ends[0]
