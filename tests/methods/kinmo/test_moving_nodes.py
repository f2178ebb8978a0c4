"""Nodes of the hierarchy that move, and the probability of missed motions."""

from __future__ import annotations

import pytest
from edge_predictions import uniform_predictions
from rankers import UniformRanker
from small_shapes import cabinet_shape

from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.moving_nodes import MovingNodes, find_moving_nodes


def test_missed_motions_count_for_large_nodes_that_do_not_move_along() -> None:
    shape = prepare_shape(cabinet_shape()[0], points=64)
    frame, top, door, board, handle = (shape.part_names.index(n) for n in ("frame", "top", "door", "surface_board", "handle"))

    def moving_nodes(**rest: float) -> MovingNodes:
        """Moving nodes if the named nodes rest with the given probabilities, and all others certainly."""
        probabilities = [rest.get(name, 1.0) for name in shape.part_names[1:]]
        return find_moving_nodes(shape, UniformRanker(probabilities), uniform_predictions(shape, FIXED=1.0))

    assert shape.parents[board] == shape.parents[handle] == door
    assert shape.parents[top] == frame
    assert moving_nodes(door=0.1, surface_board=0.6, handle=0.6).moving.keys() == {door}
    parts_of_the_door = moving_nodes(door=0.1, surface_board=0.6, handle=0.6)
    assert parts_of_the_door.missed_motion_probability == 0.0
    assert moving_nodes(door=0.1, top=0.7, frame=0.9).missed_motion_probability == pytest.approx(0.3)
    above_a_moving_node = moving_nodes(top=0.1, frame=0.6, door=0.8)
    assert above_a_moving_node.missed_motion_probability == pytest.approx(0.2), "that of the door, not of the frame"
    assert moving_nodes(handle=0.7).moving == {}
    assert moving_nodes(handle=0.7).missed_motion_probability == 0.0, "the handle is too small"
    assert moving_nodes(surface_board=0.7).missed_motion_probability == pytest.approx(0.3)
