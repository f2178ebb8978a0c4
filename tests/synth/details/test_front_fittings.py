"""Handles and fittings of fronts: they stand on the front and stay within it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinmo.core.shape import Mesh
from kinmo.synth.details import front_fittings
from kinmo.synth.details.casework_fronts import Fronts, Opening
from kinmo.synth.details.front_fittings import add_fittings
from kinmo.synth.details.handles import knob_handle, pull
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node


def extent(pieces: list[Mesh]) -> tuple[np.ndarray, np.ndarray]:
    points = np.concatenate([piece.vertices for piece in pieces])
    return points.min(axis=0), points.max(axis=0)


def test_fittings_lie_on_their_front_and_do_not_stand_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front_fittings, "FITTED_SHARE", 1.0)
    names = set()
    for seed in range(150):
        draw, above = Draw(np.random.default_rng(seed)), Node("door")
        nodes = add_fittings(draw, above, (-0.5, 0.0), (0.5, 0.8), 0.3, draw.pick(["left", "right", "top", "bottom", ""]))
        assert nodes == above.children
        low, high = extent([piece for node in nodes for piece in node.pieces])
        assert np.all(low[:2] > (-0.55, -0.05)) and np.all(high[:2] < (0.55, 0.85))
        assert low[2] > 0.25 and high[2] < 0.6
        names.update(node.name for node in nodes)
    assert {"hinge", "lock", "keyhole", "stud", "other_leaf"} <= names


def test_knobs_are_about_as_wide_and_high_as_asked() -> None:
    for seed in range(80):
        low, high = extent(knob_handle(Draw(np.random.default_rng(seed)), 0.02, 0.05))
        assert abs(low[2]) < 0.01 and 0.03 < high[2] < 0.08
        assert np.all(high[:2] - low[:2] < 0.06)


def test_handles_as_wide_as_long_fit_on_narrow_fronts() -> None:
    for seed in range(120):
        low, high = extent(pull(Draw(np.random.default_rng(seed)), 0.5, (0, 0, 0), vertical=False, room=0.1))
        assert high[1] - low[1] < 0.4


def test_handles_of_one_piece_of_furniture_are_mostly_alike() -> None:
    alike = 0
    for seed in range(60):
        draw, opening = Draw(np.random.default_rng(seed)), Opening(0, 0, 1, 0.4, 0.5, 0)
        fronts = replace(Fronts.random(draw, 0.03), gap=0.0)
        first, second = (fronts.grip(draw, 0.2, (0, 0, 0), opening, vertical=False) for _ in range(2))
        alike += np.array_equal(np.concatenate([p.vertices for p in first]), np.concatenate([p.vertices for p in second]))
    assert 0.5 < alike / 60 < 0.9
