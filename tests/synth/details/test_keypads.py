"""Keypads: which keys move, and how."""

from __future__ import annotations

import numpy as np

from kinmo.synth.details.keypads import add_keypad
from kinmo.synth.draw import Draw
from kinmo.synth.primitives import box
from kinmo.synth.synth_object import Link, Node


def fields(*, lookalikes: bool) -> list[tuple[Node, Link, list[Link]]]:
    made = []
    for seed in range(80):
        panel, carrier = Node("panel"), Link("frame", [Node("frame", pieces=[box((1, 1, 1))])])
        draw = Draw(np.random.default_rng(seed))
        made.append((panel, carrier, add_keypad(draw, panel, carrier, (0, 0, 0.5), (0.4, 0.6), "key", lookalikes=lookalikes)))
    return made


def test_every_key_has_one_owner() -> None:
    for panel, carrier, links in fields(lookalikes=True):
        owned = [*carrier.nodes[1:], *(node for link in links for node in link.nodes)]
        assert len(owned) == len(panel.children) and set(owned) == set(panel.children)


def test_most_flat_keys_are_fixed_and_most_raised_keys_move() -> None:
    moving: dict[bool, list[bool]] = {True: [], False: []}
    for panel, _, links in fields(lookalikes=True):
        flat = float(np.ptp(panel.children[0].pieces[0].vertices[:, 2])) == 0.0
        moving[flat].append(bool(links))
    assert np.mean(moving[True]) < 0.3 < 0.7 < np.mean(moving[False])


def test_without_lookalikes_every_key_moves() -> None:
    for panel, _, links in fields(lookalikes=False):
        assert len(links) == len(panel.children)
        assert all(link.motion is not None and abs(link.motion.direction[2]) == 1.0 for link in links)


def test_some_fields_move_in_part() -> None:
    assert any(0 < len(links) < len(panel.children) for panel, _, links in fields(lookalikes=True))
