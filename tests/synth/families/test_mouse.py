"""Computer mice: keys that tip join the back, and keys that slide stand clear of it."""

from __future__ import annotations

from synth_objects import bounds_of, build_object, link_pieces, moving_links


def test_tipping_buttons_join_the_back_and_sliding_ones_stand_clear_of_it() -> None:
    seen = set()
    for seed in range(40):
        shape = build_object("mouse", seed)
        _, back = shape.links[0].nodes[0].pieces[:2]
        edge = bounds_of([back])[0][2]
        for link in moving_links(shape):
            if link.name != "button" or (abs(link.motion.direction[0]) > 0.9 and not link.motion.is_hinge):
                continue  # buttons at the side
            rear = bounds_of(link_pieces(link))[1][2]
            assert (rear > edge) == link.motion.is_hinge
            seen.add(link.motion.is_hinge)
    assert seen == {True, False}
