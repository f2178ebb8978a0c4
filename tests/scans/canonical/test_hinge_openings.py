"""Openings of hinges with known and with guessed limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scanned_objects import hinge, slider

from kinmo.core.mobility import Body, Mobility
from kinmo.scans.canonical.hinge_openings import hinge_opening, with_sampled_openings


def test_an_opening_counts_from_the_closed_pose() -> None:
    door = hinge((0.0, 0.0, 0.0), upper=2.0)
    assert hinge_opening(door) == pytest.approx(2.0)
    swinging = replace(door, lower=-1.5, upper=1.5, rest=0.0)
    assert hinge_opening(swinging) == pytest.approx(1.5)
    assert hinge_opening(replace(door, lower=None, upper=None)) is None
    assert hinge_opening(slider()) is None


def test_hinges_without_a_known_end_get_sampled_openings() -> None:
    free, stopped = hinge((0.0, 0.0, 0.0), upper=np.pi / 2), hinge((0.0, 0.0, 0.0), upper=1.0)
    bodies = [
        Body(0, "base", ()),
        Body(1, "free", (), 0, free),
        Body(2, "stopped", (), 0, stopped),
        Body(3, "drawer", (), 0, slider()),
    ]
    mobility = Mobility(tuple(bodies))
    for turn, expected in ((np.pi, np.pi), (0.5, 0.5)):
        opened = with_sampled_openings(mobility, np.pi / 2, (turn,), np.random.default_rng(0))
        uppers = [body.joint.upper for body in opened.bodies if body.joint is not None]
        assert uppers == [pytest.approx(expected), 1.0, slider().upper]
    swinging = replace(free, lower=-np.pi / 2, upper=np.pi / 2, rest=0.0)
    two = Mobility((bodies[0], replace(bodies[1], joint=swinging)))
    joint = with_sampled_openings(two, np.pi / 2, (0.3,), np.random.default_rng(0)).bodies[1].joint
    assert joint is not None
    assert (joint.lower, joint.rest, joint.upper) == (-0.3, 0.0, 0.3), "to both sides of the closed pose"
    assert with_sampled_openings(mobility, np.pi / 2, (), np.random.default_rng(0)) is mobility
