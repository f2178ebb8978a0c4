"""Choice of the bodies that move among proposals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from groupings import grouped_without_network

from kinmo.core.joint import Joint, JointKind
from kinmo.features.prepared_shape import leaf_meshes
from kinmo.features.shape_geometry import ShapeGeometry
from kinmo.features.shape_preparation import prepare_shape
from kinmo.methods.kinmo.body_selection import SelectedBodies, choose_consistent, innermost_owners, select_bodies
from kinmo.methods.kinmo.grouping.grouped_shape import Group
from kinmo.methods.kinmo.ranking.shape_views import ShapeView

FRAME, DOOR, HANDLE, DRAWER = range(4)
BOXES = [
    ((0, 0, 0), (1, 2, 1)),
    ((0, 0, 1), (1, 1, 1.1)),
    ((0.8, 0.4, 1.1), (0.9, 0.6, 1.2)),
    ((0, 1.1, 1), (1, 1.9, 1.1)),
]
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.zeros(3))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))


@dataclass
class MovingGroups:
    """Ranker that knows the probability that each group of leaves moves, 0.01 for those it does not list."""

    moves: Mapping[Group, float] = field(default_factory=dict)

    def probabilities(self, view: ShapeView) -> tuple[list[np.ndarray], np.ndarray]:
        names = {row: group for group, row in view.features.group_of.items()}
        moves = np.array([self.moves.get(names[row], 0.01) for row in view.groups])
        counts = view.features.counts(view.groups)
        return [np.full(count, chance / count) for count, chance in zip(counts, moves, strict=True)], 1.0 - moves


def selected(moves: Mapping[Group, float]) -> SelectedBodies:
    made = replace(shape_of_boxes(BOXES, ()), mobility=None)
    shape = prepare_shape(made, points=64)
    grouped = grouped_without_network(shape, (frozenset({DOOR, HANDLE}),))
    return select_bodies(grouped, ShapeGeometry.of_prepared(shape, leaf_meshes(made, shape)), MovingGroups(moves))


def test_every_leaf_belongs_to_one_body_and_the_base_is_first() -> None:
    found = selected({(DOOR, HANDLE): 0.9, (DOOR,): 0.7, (DRAWER,): 0.8})
    assert found.bodies == ((FRAME,), (DOOR, HANDLE), (DRAWER,))
    assert found.parents == (None, None, None)
    assert [ranked[0].joint is None for ranked in found.ranked] == [True, False, False]


def test_the_base_is_all_that_does_not_move() -> None:
    assert selected({}).bodies == ((FRAME, DOOR, HANDLE, DRAWER),)


def test_something_rests_even_if_everything_seems_to_move() -> None:
    found = selected({(FRAME,): 0.6, (DOOR, HANDLE): 0.9, (DRAWER,): 0.8})
    assert found.bodies == ((FRAME,), (DOOR, HANDLE), (DRAWER,))


def test_large_bodies_that_may_move_are_reported_as_missed() -> None:
    assert selected({(DOOR, HANDLE): 0.9, (DRAWER,): 0.4}).missed_motion_probability == pytest.approx(0.4)
    assert selected({(DOOR, HANDLE): 0.9, (DOOR,): 0.4}).missed_motion_probability == pytest.approx(0.01)


def test_bodies_apart_are_chosen_and_overlapping_ones_are_not() -> None:
    areas = np.ones(6)
    proposals = [(0, 1), (1, 2), (3,), (4, 5)]
    assert choose_consistent(proposals, dict.fromkeys(range(4), HINGE), areas) == [0, 2, 3]


def test_a_small_body_in_a_large_one_needs_another_joint() -> None:
    areas = np.ones(4)
    assert choose_consistent([(0, 1, 2, 3), (0,)], {0: HINGE, 1: SLIDE}, areas) == [0, 1]
    assert choose_consistent([(0, 1, 2, 3), (0,)], {0: HINGE, 1: HINGE}, areas) == [0]
    assert choose_consistent([(0, 1, 2, 3), (0, 1, 2)], {0: HINGE, 1: SLIDE}, areas) == [0], "not much smaller"


def test_a_tiny_part_is_in_one_body_alone() -> None:
    areas = np.array([1.0, 1.0, 1e-3])
    assert choose_consistent([(0,), (0, 2)], {0: HINGE, 1: SLIDE}, areas) == [0]


def test_inner_bodies_own_their_leaves() -> None:
    assert innermost_owners([(0, 1, 2), (1,)], 4, np.ones(4)) == [(0, 2), (1,)]
