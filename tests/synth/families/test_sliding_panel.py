"""Sliding panels: every panel slides across the way it faces, and clears its opening."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, moving_links

from kinmo.synth.synth_object import Link

SEEDS = 60


def panels() -> list[Link]:
    shapes = [build_object("sliding_panel", seed) for seed in range(SEEDS)]
    return [link for shape in shapes for link in moving_links(shape) if link.name != "drawer"]


def test_panels_slide_along_themselves() -> None:
    for link in panels():
        assert link.motion is not None and not link.motion.is_hinge
        low, high = bounds_of(link_pieces(link))
        along = np.abs(link.motion.direction) @ (high - low)
        assert along > 1.5 * (high - low).min()


def test_panels_slide_sideways_and_up_and_some_are_shown_open() -> None:
    found = panels()
    upright = [abs(link.motion.direction[1]) > 0.9 for link in found if link.motion is not None]
    assert 0.1 < np.mean(upright) < 0.6
    assert any(link.motion.a < -1e-6 and link.motion.b > 1e-6 for link in found if link.motion is not None)
