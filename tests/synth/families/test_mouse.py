from __future__ import annotations

from built import box_of, built, movable


def test_buttons_that_tip_are_of_a_piece_with_the_back_and_those_that_slide_stand_clear_of_it() -> None:
    seen = set()
    for seed in range(40):
        shape = built("mouse", seed)
        _, back = shape.links[0].nodes[0].pieces[:2]
        edge = box_of([back])[0][2]
        for link in movable(shape):
            if link.name != "button" or (abs(link.motion.direction[0]) > 0.9 and not link.motion.is_hinge):
                continue  # of those at the side nothing is asked
            rear = box_of([piece for leaf in link.leaves() for piece in leaf.pieces])[1][2]
            assert (rear > edge) == link.motion.is_hinge
            seen.add(link.motion.is_hinge)
    assert seen == {True, False}
