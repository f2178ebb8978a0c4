"""Vehicles, cycles and aircraft: what rolls, steers and folds does so about the right lines."""

from __future__ import annotations

import numpy as np
import pytest
from synth_objects import axis_distances, bounds_of, build_object, link_pieces, link_vertices, moving_links

from kinmo.synth.synth_object import Link

SEEDS = 25


def links(name: str, *wanted: str) -> list[Link]:
    shapes = [build_object(name, seed) for seed in range(SEEDS)]
    return [link for shape in shapes for link in moving_links(shape) if link.name in wanted]


@pytest.mark.parametrize("name", ["vehicle", "cycle", "aircraft"])
def test_wheels_roll_about_their_middle(name: str) -> None:
    found = links(name, "wheel")
    assert len(found) >= SEEDS
    for link in found:
        assert link.motion is not None and link.motion.no_limit
        low, high = bounds_of(link_pieces(link))
        middle = 0.5 * (low + high) - link.motion.origin
        unit = link.motion.direction
        assert np.linalg.norm(middle - unit * (middle @ unit)) < 0.1 * (high - low).max()


def test_doors_open_outwards() -> None:
    for link in links("vehicle", "door"):
        if link.motion is None or not link.motion.is_hinge or abs(link.motion.direction[1]) < 0.5:
            continue
        middle = np.append(np.mean(bounds_of(link_pieces(link)), axis=0), 1.0)
        shut, opened = link.motion.at(link.motion.a) @ middle, link.motion.at(link.motion.b) @ middle
        outside = shut[2] < -0.4 or abs(opened[0]) > abs(shut[0]) or opened[2] < shut[2] - 0.05
        assert outside


def test_bonnets_and_lids_fold_up() -> None:
    for link in links("vehicle", "hood", "bonnet", "trunk", "boot", "lid"):
        if link.motion is None or abs(link.motion.direction[1]) > 0.5:
            continue
        middle = np.append(np.mean(bounds_of(link_pieces(link)), axis=0), 1.0)
        assert (link.motion.at(link.motion.b) @ middle)[1] > (link.motion.at(link.motion.a) @ middle)[1]


def test_the_front_wheel_of_a_cycle_hangs_on_its_fork() -> None:
    for seed in range(SEEDS):
        shape = build_object("cycle", seed)
        fork = next(link for link in shape.links if link.name == "fork")
        assert [link.name for link in shape.links if link.parent is fork] == ["wheel"]
        assert fork.motion is not None and fork.motion.direction[1] > 0.8
        assert axis_distances(link_vertices(fork), fork).min() < 0.05


def test_control_surfaces_turn_about_their_front_edge() -> None:
    for link in links("aircraft", "flap", "aileron", "elevator", "rudder"):
        assert link.motion is not None
        reach = axis_distances(link_vertices(link), link)
        assert reach.min() < 0.3 * reach.max()
