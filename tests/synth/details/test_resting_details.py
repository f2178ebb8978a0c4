"""Details that rest: keys fill their field without overlap, and details stay on the body that carries them."""

from __future__ import annotations

import numpy as np
import pytest
from synth_objects import build_object, links_with_leaf

from kinmo.synth.details.resting_details import DETAIL_NAMES, add_body_details, key_caps, resting_detail
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node


def test_keys_fill_their_field_and_do_not_overlap() -> None:
    counts = []
    for seed in range(40):
        keys = key_caps(Draw(np.random.default_rng(seed)), 3.0, 1.0, 0.02)
        points = [np.concatenate([piece.vertices for piece in key]) for key in keys]
        low = np.array([key.min(axis=0) for key in points])[:, :2]
        high = np.array([key.max(axis=0) for key in points])[:, :2]
        assert low.min(axis=0) == pytest.approx([-1.5, -0.5], abs=0.12) and high.max(axis=0)[1] < 0.5
        meets = np.all((low[:, None] < high[None] - 1e-9) & (high[:, None] > low[None] + 1e-9), axis=2)
        assert meets.sum() == len(keys)
        assert max(float(key[:, 2].max()) for key in points) < 0.025
        counts.append(len(keys))
    assert min(counts) < 50 and max(counts) > 90


@pytest.mark.parametrize("kind", list(DETAIL_NAMES))
def test_a_detail_is_flat_and_about_as_wide_as_asked(kind: str) -> None:
    for seed in range(20):
        pieces = resting_detail(Draw(np.random.default_rng(seed)), kind, 0.1)
        extent = np.ptp(np.concatenate([piece.vertices for piece in pieces]), axis=0)
        assert 0.03 < extent[0] < 0.5 and extent[2] < 0.06


def test_details_of_a_body_lie_at_its_faces() -> None:
    for seed in range(30):
        above = Node("body")
        nodes = add_body_details(Draw(np.random.default_rng(seed)), above, (-1, 0, -0.5), (1, 1, 0.5))
        assert nodes and set(nodes) == set(above.children)
        for node in nodes:
            for piece in node.pieces:
                depth = np.min(np.abs(np.concatenate([piece.vertices - [-1, 0, -0.5], [1, 1, 0.5] - piece.vertices], axis=1)))
                assert depth < 0.1


def test_keys_of_laptops_rest_on_the_base() -> None:
    loose = 0
    for seed in range(30):
        shape = build_object("laptop", seed)
        assert sum(link.motion is not None for link in shape.links) == 1
        assert not any(leaf.name == "keyboard" for link in links_with_leaf(shape, "screen") for leaf in link.leaves())
        loose += sum(len(leaf.pieces) for leaf in shape.links[0].leaves()) > 40
    assert loose > 15
