"""Cameras: lids swing away from the body, and rings turn about the lens."""

from __future__ import annotations

import numpy as np
from synth_objects import bounds_of, build_object, link_pieces, link_vertices, moving_links


def test_lids_and_screens_swing_away_from_the_body() -> None:
    seen = set()
    for seed in range(60):
        shape = build_object("camera", seed)
        body = np.mean(bounds_of(shape.links[0].nodes[0].pieces[:1]), axis=0)
        for link in moving_links(shape):
            leaf = link.nodes[0].name
            if not link.motion.is_hinge or leaf not in ("lid", "screen", "frame") or link.parent is not shape.links[0]:
                continue
            middle = np.mean(bounds_of(link_pieces(link)), axis=0)
            ends = (link.motion.at(value) @ np.append(middle, 1.0) for value in (link.motion.a, link.motion.b))
            closed, opened = sorted(np.linalg.norm(end[:3] - body) for end in ends)
            assert opened > closed
            half = link.motion.at(0.5 * (link.motion.a + link.motion.b)) @ np.append(middle, 1.0)
            assert np.linalg.norm(half[:3] - body) > closed - 1e-6
            seen.add(leaf)
    assert seen >= {"lid", "screen"}


def test_rings_turn_about_the_middle_of_their_lens() -> None:
    rings = 0
    for seed in range(60):
        for link in moving_links(build_object("camera", seed)):
            if link.nodes[0].name == "ring" and link.motion.has_position:
                rings += 1
                low, high = link_vertices(link).min(axis=0), link_vertices(link).max(axis=0)
                assert np.linalg.norm((0.5 * (low + high) - link.motion.origin)[:2]) < 0.02
    assert rings > 3
