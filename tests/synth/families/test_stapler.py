"""Staplers: jaws turn about one pin near an end, magazines slide out, and anvils turn."""

from __future__ import annotations

from synth_objects import axis_distances, build_object, link_vertices, moving_links


def test_lid_and_magazine_turn_about_one_line() -> None:
    pairs = 0
    for seed in range(60):
        links = {link.name: link for link in moving_links(build_object("stapler", seed))}
        body, lid = links.get("body"), links["lid"]
        if body is not None and body.motion.is_hinge:
            pairs += 1
            assert axis_distances(body.motion.origin[None], lid)[0] < 1e-9
    assert pairs > 30


def test_lids_turn_about_a_line_at_their_end() -> None:
    for seed in range(60):
        lid = next(link for link in moving_links(build_object("stapler", seed)) if link.name == "lid")
        distances = axis_distances(link_vertices(lid), lid)
        assert distances.min() < 0.35 * distances.max()


def test_some_magazines_slide_and_some_anvils_turn() -> None:
    links = [link for seed in range(80) for link in moving_links(build_object("stapler", seed))]
    assert any(link.name == "body" and not link.motion.is_hinge for link in links)
    assert any(link.name == "anvil" for link in links)
