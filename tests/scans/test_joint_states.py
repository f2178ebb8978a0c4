"""States of joints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from kinmo.core.mobility import Body, Mobility
from kinmo.scans.joint_states import articulations, joint_range, opened_as_usual, opening
from scanned import cupboard_object, hinge, slider


def test_every_value_is_in_the_range_of_its_joint() -> None:
    mobility = cupboard_object().mobility
    for how in ("independent", "lockstep"):
        for state in articulations(mobility, 20, how, np.random.default_rng(0)):
            for index, body in mobility.movable():
                assert body.joint is not None
                low, high = joint_range(body.joint)
                assert low - 1e-12 <= state.values[index] <= high + 1e-12


def test_in_lockstep_all_joints_go_through_their_ranges_in_equal_steps() -> None:
    mobility = cupboard_object().mobility
    states = list(articulations(mobility, 4, "lockstep", np.random.default_rng(0)))
    for index, body in mobility.movable():
        assert body.joint is not None
        low, high = joint_range(body.joint)
        assert [state.values[index] for state in states] == pytest.approx(np.linspace(low, high, 4))


def test_as_in_the_release_limits_do_not_count() -> None:
    mobility = cupboard_object().mobility
    first, last = articulations(mobility, 2, "release", np.random.default_rng(0))
    drawer, door = 1, 3
    assert (first.values[door], last.values[door]) == pytest.approx((math.radians(-90), math.radians(30)))
    assert (first.values[drawer], last.values[drawer]) == pytest.approx((0.0, 0.4))


def test_a_hinge_without_limits_turns_a_quarter_either_way_and_a_slider_without_stays() -> None:
    free = replace(hinge((0.0, 0.0, 0.0)), lower=None, upper=None, rest=1.0)
    assert joint_range(free) == pytest.approx((1.0 - math.pi / 2, 1.0 + math.pi / 2))
    assert joint_range(replace(slider(), lower=None, upper=None, rest=0.2)) == (0.2, 0.2)


def test_a_screw_turns_too() -> None:
    states = list(articulations(cupboard_object().mobility, 5, "independent", np.random.default_rng(1)))
    assert all(set(state.turns) == {2} for state in states)
    assert len({state.turns[2] for state in states}) == 5


def test_how_far_a_hinge_opens_is_counted_from_where_it_is_closed() -> None:
    door = hinge((0.0, 0.0, 0.0), upper=2.0)
    assert opening(door) == pytest.approx(2.0)
    swinging = replace(door, lower=-1.5, upper=1.5, rest=0.0)
    assert opening(swinging) == pytest.approx(1.5)
    assert opening(replace(door, lower=None, upper=None)) is None
    assert opening(slider()) is None


def test_hinges_that_nothing_stops_open_as_far_as_others_do() -> None:
    free, stopped = hinge((0.0, 0.0, 0.0), upper=np.pi / 2), hinge((0.0, 0.0, 0.0), upper=1.0)
    bodies = [
        Body(0, "base", ()),
        Body(1, "free", (), 0, free),
        Body(2, "stopped", (), 0, stopped),
        Body(3, "drawer", (), 0, slider()),
    ]
    mobility = Mobility(tuple(bodies))
    for turn, expected in ((np.pi, np.pi), (0.5, 0.5)):
        opened = opened_as_usual(mobility, np.pi / 2, (turn,), np.random.default_rng(0))
        uppers = [body.joint.upper for body in opened.bodies if body.joint is not None]
        assert uppers == [pytest.approx(expected), 1.0, slider().upper]
    swinging = replace(free, lower=-np.pi / 2, upper=np.pi / 2, rest=0.0)
    two = Mobility((bodies[0], replace(bodies[1], joint=swinging)))
    joint = opened_as_usual(two, np.pi / 2, (0.3,), np.random.default_rng(0)).bodies[1].joint
    assert joint is not None
    assert (joint.lower, joint.rest, joint.upper) == (-0.3, 0.0, 0.3), "to both sides of where it is closed"
    assert opened_as_usual(mobility, np.pi / 2, (), np.random.default_rng(0)) is mobility
