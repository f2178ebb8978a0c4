"""Chairs: casters swivel and roll, and seats turn about the column."""

from __future__ import annotations

import numpy as np
from synth_objects import axis_distances, build_object, link_vertices, moving_links


def test_wheels_roll_on_forks_that_swivel_about_a_vertical_axis() -> None:
    rolling = 0
    for seed in range(40):
        for wheel in (link for link in moving_links(build_object("chair", seed)) if link.name == "wheel"):
            rolling += 1
            fork = wheel.parent
            assert fork is not None
            if fork.name != "caster":
                continue  # a fork that does not swivel
            assert abs(fork.motion.direction[1]) > 0.999
            assert abs(wheel.motion.direction[1]) < 1e-6
            corners = link_vertices(wheel)
            distances = axis_distances(corners, wheel)
            assert distances.max() < 0.05
    assert rolling > 10


def test_seats_turn_about_the_column() -> None:
    for seed in range(40):
        shape = build_object("chair", seed)
        seat = next((link for link in moving_links(shape) if link.name == "seat"), None)
        if seat is None or abs(seat.motion.direction[0]) > 0.99:
            continue  # fixed seats, and seats that tip
        assert np.allclose(np.abs(seat.motion.direction), (0, 1, 0))
        cushion = [p for leaf in seat.leaves() if leaf.name == "seat_surface" for p in leaf.pieces]
        middle = np.mean([0.5 * (p.vertices.min(0) + p.vertices.max(0)) for p in cushion], axis=0)
        if not seat.motion.is_hinge and not seat.motion.rotates:
            continue
        assert np.linalg.norm((middle - seat.motion.origin)[[0, 2]]) < 0.02
