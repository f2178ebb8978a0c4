"""Staplers: magazine and lid share one pin near an end."""

from __future__ import annotations

from synth_objects import axis_distances, build_object, link_vertices, moving_links


def test_magazine_and_lid_turn_about_one_line_near_an_end() -> None:
    for seed in range(30):
        body, lid = moving_links(build_object("stapler", seed))
        assert axis_distances(body.motion.origin[None], lid)[0] < 1e-9
        corners = link_vertices(lid)
        distances = axis_distances(corners, lid)
        assert distances.min() < 0.25 * distances.max()
