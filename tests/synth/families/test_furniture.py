"""Tables and storage furniture: drawers open to any side, and doors fold, slide and hide other parts."""

from __future__ import annotations

import numpy as np
from synth_objects import build_object, link_pieces, moving_links, share_inside, surface_points

from kinmo.synth.synth_object import Link, SynthObject


def links_of(name: str, count: int) -> list[tuple[SynthObject, Link]]:
    shapes = [build_object(name, seed) for seed in range(count)]
    return [(shape, link) for shape in shapes for link in moving_links(shape)]


def test_drawers_of_tables_open_to_all_sides() -> None:
    ways = [
        np.sign(link.motion.b - abs(link.motion.a)) * link.motion.direction
        for _, link in links_of("table", 250)
        if link.name == "drawer" and link.motion is not None
    ]
    forward = np.array([way @ (0, 0, 1) for way in ways])
    assert 0.6 < np.mean(forward > 0.99) < 0.97
    assert np.sum(forward < -0.99) > 5
    assert np.sum(np.abs(forward) < 0.01) > 5


def test_some_tables_have_no_joint_and_most_have() -> None:
    joints = [sum(link.motion is not None for link in build_object("table", seed).links) for seed in range(120)]
    assert 0.02 < np.mean(np.array(joints) == 0) < 0.25
    assert max(joints) > 5


def test_drawers_leave_their_table_when_they_open() -> None:
    for shape, link in links_of("table", 60):
        if link.name == "drawer" and link.motion is not None:
            points = surface_points(link_pieces(link), 60)
            matrix = link.motion.at(link.motion.b if abs(link.motion.b) > abs(link.motion.a) else link.motion.a)
            opened = points @ matrix[:3, :3].T + matrix[:3, 3]
            body = [piece for other in shape.links if other.motion is None for piece in link_pieces(other)]
            assert share_inside(opened, body) < share_inside(points, body) + 0.3


def test_some_doors_hang_on_doors_and_some_hide_drawers() -> None:
    found = links_of("storage_furniture", 80)
    assert any(link.parent.name == "cabinet_door" for _, link in found if link.name == "cabinet_door")
    assert any(link.motion.direction[1] > 0.9 for _, link in found if link.name == "cabinet_door" and not link.motion.is_hinge)
