"""From ranked nodes to bodies."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from articulated import shape_of_boxes
from kinmo.methods.kinmo.ranked_mobility import SaidNodes, moving_nodes, predicted_bodies, ranked_bodies, with_limits
from small_shapes import cabinet, cabinet_shape

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.motion_types import MotionType
from kinmo.features.prepared_shape import PreparedShape, leaf_meshes
from kinmo.features.shape_preparation import prepare_shape
from kinmo.learning.motion_gnn.edge_predictions import EdgePredictions
from kinmo.methods.kinmo.ranking.ranked_joints import same_joint
from kinmo.methods.kinmo.ranking.ranking_batches import View

SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))
LIFT = Joint(JointKind.PRISMATIC, np.array([0.0, 1.0, 0.0]), np.zeros(3))
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.3, 0.0, 0.1]))


def all_fixed(shape: PreparedShape) -> EdgePredictions:
    """A GNN that holds everything to be fixed to everything."""
    types = np.zeros((len(shape.edges), len(MotionType)))
    types[:, MotionType.FIXED] = 1.0
    return EdgePredictions(types, np.tile([0.0, 1.0, 0.0], (len(types), 1)), np.zeros((len(types), 3)))


def none_fixed(shape: PreparedShape) -> EdgePredictions:
    """A GNN that holds nothing to be fixed to anything."""
    told = all_fixed(shape)
    return replace(told, type_probabilities=np.roll(told.type_probabilities, 1, axis=1))


def with_box(shape: PreparedShape, node: int, center: list[float], half_extents: list[float]) -> PreparedShape:
    """The shape with another box, along the frame's axes, of one node."""
    boxes = shape.minimum_boxes
    centers, axes, sizes = boxes.centers.copy(), boxes.axes.copy(), boxes.half_extents.copy()
    centers[node], axes[node], sizes[node] = center, np.eye(3), half_extents
    return replace(shape, minimum_boxes=replace(boxes, centers=centers, axes=axes, half_extents=sizes))


def moving_pair(shape: PreparedShape) -> tuple[int, int]:
    """Two leaves below one moving node."""
    node = next(n for n, name in enumerate(shape.part_names) if name in ("door", "drawer"))
    first, second = (n for n, parent in enumerate(shape.parents) if parent == node)
    return first, second


def touching(shape: PreparedShape, distance: float) -> PreparedShape:
    return replace(shape, edge_distances=np.full(len(shape.edges), distance))


@dataclass
class Undecided:
    """A ranking that knows nothing, and rather says that nothing moves; of unit i it is as sure as `rest[i]`."""

    rest: Sequence[float] | None = None

    def probabilities(self, view: View) -> tuple[list[np.ndarray], np.ndarray]:
        counts = [view.evidence.rows(unit).stop - view.evidence.rows(unit).start for unit in view.units]
        rest = np.full(len(counts), 0.8) if self.rest is None else np.array(self.rest)
        return [np.full(count, (1.0 - still) / count) for count, still in zip(counts, rest, strict=True)], rest


@pytest.mark.parametrize("kind", list(JointKind))
def test_a_body_whose_kind_is_told_moves_so(kind: JointKind) -> None:
    box, lid = ((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))
    bodies = (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE))
    shape = prepare_shape(shape_of_boxes([box, lid], bodies), points=64)
    asked = ranked_bodies(shape, None, shape.body_leaves, Undecided(), all_fixed(shape))
    told = ranked_bodies(shape, None, shape.body_leaves, Undecided(), all_fixed(shape), kinds=[None, kind])
    assert asked[1][0].joint is None and told[1][0].joint.kind is kind
    assert told[0][0].joint is None and told[0][0].score == asked[0][0].score


class ByEvidence:
    """A ranking that goes by all that the evidence says."""

    def probabilities(self, view: View) -> tuple[list[np.ndarray], np.ndarray]:
        evidence = view.evidence
        odds = [np.exp(np.sin(evidence.features[evidence.rows(unit)].astype(float)).sum(axis=1)) for unit in view.units]
        rest = 0.5 + 0.4 * np.sin(evidence.unit_features[list(view.units)].astype(float).sum(axis=1))
        return [(1.0 - still) * each / each.sum() for each, still in zip(odds, rest, strict=True)], rest


def test_a_body_is_answered_alike_whether_or_not_the_shape_was_prepared_with_it() -> None:
    boxes = [((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1)), ((0.4, 1.1, 0.9), (0.6, 1.2, 1))]
    annotated = shape_of_boxes(boxes, (Body(0, "box", (1,)), Body(1, "lid", (2, 3), 0, HINGE)))
    known, unknown = prepare_shape(annotated, points=64), prepare_shape(replace(annotated, mobility=None), points=64)
    unannotated = replace(known, mobility=None, body_boxes=None, body_types={}, edge_labels=None)
    assert (1, 2) not in unknown.leaves_below
    with pytest.raises(ValueError, match="meshes: needed"):
        ranked_bodies(unknown, None, known.body_leaves, ByEvidence(), all_fixed(unknown))
    expected, found, again = (
        ranked_bodies(shape, leaf_meshes(annotated, shape), known.body_leaves, ByEvidence(), all_fixed(shape))
        for shape in (known, unknown, unannotated)
    )
    for one, other in zip(expected * 2, found + again, strict=True):
        assert [answer.type for answer in one] == [answer.type for answer in other]
        assert [answer.score for answer in one] == [answer.score for answer in other]
        for a, b in zip(one, other, strict=True):
            if a.joint is not None:
                np.testing.assert_array_equal(a.joint.direction, b.joint.direction)
                np.testing.assert_array_equal(a.joint.pivot, b.joint.pivot)


def test_the_best_answer_is_swept_as_if_there_were_no_others() -> None:
    box, lid = ((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))
    made = shape_of_boxes([box, lid], (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE)))
    shape = prepare_shape(made, points=64)
    meshes = leaf_meshes(made, shape)
    kinds = [None, JointKind.REVOLUTE]
    _, answers = ranked_bodies(shape, meshes, shape.body_leaves, ByEvidence(), all_fixed(shape), kinds=kinds)
    limited, alone = with_limits(answers, shape, meshes, [1]), with_limits(answers[:1], shape, meshes, [1])
    assert len(limited) == len(answers) > 1
    assert (limited[0].joint.lower, limited[0].joint.upper) == (alone[0].joint.lower, alone[0].joint.upper)
    for answer, told in zip(answers, limited, strict=True):
        assert (answer.joint is None) == (told.joint is None)
        assert answer.joint is None or "sweep" in told.terms


@pytest.mark.parametrize(
    ("rests", "rest", "moving"),
    [
        ("any", (0.8, 0.9), ()),
        ("first", (0.8, 0.9), (1,)),
        ("one", (0.8, 0.9), (0,)),
        ("one", (0.9, 0.8), (1,)),
        ("one", (0.4, 0.3), (0, 1)),
    ],
)
def test_as_many_bodies_rest_as_may(rests: str, rest: tuple[float, float], moving: tuple[int, ...]) -> None:
    box, lid = ((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))
    shape = prepare_shape(shape_of_boxes([box, lid], (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE))), points=64)
    answers = ranked_bodies(shape, None, shape.body_leaves, Undecided(rest), all_fixed(shape), rests=rests)
    assert tuple(index for index, found in enumerate(answers) if found[0].joint is not None) == moving


def test_the_surest_is_told_of_what_may_move_after_all_if_it_is_large_and_does_not_move_along() -> None:
    shape = prepare_shape(cabinet_shape()[0], points=64)
    frame, top, door, board, handle = (shape.part_names.index(n) for n in ("frame", "top", "door", "surface_board", "handle"))

    def told(**rest: float) -> SaidNodes:
        """Every node rests, but for those that are named, by these chances."""
        chances = [rest.get(name, 1.0) for name in shape.part_names[1:]]
        return moving_nodes(shape, Undecided(chances), all_fixed(shape))

    assert shape.parents[board] == shape.parents[handle] == door
    assert shape.parents[top] == frame
    assert told(door=0.1, surface_board=0.6, handle=0.6).moving.keys() == {door}
    assert told(door=0.1, surface_board=0.6, handle=0.6).doubt == 0.0, "the parts of the door"
    assert told(door=0.1, top=0.7, frame=0.9).doubt == pytest.approx(0.3)
    assert told(top=0.1, frame=0.6, door=0.8).doubt == pytest.approx(0.2), "not the frame, a part of which moves"
    assert told(handle=0.7).moving == {}
    assert told(handle=0.7).doubt == 0.0, "too small"
    assert told(surface_board=0.7).doubt == pytest.approx(0.3)


@pytest.mark.parametrize(("rest", "moving"), [((0.1, 0.2), (2,)), ((0.1, 0.9), (2,)), ((0.9, 0.1), (2,))])
def test_what_everything_rests_on_does_not_move(rest: tuple[float, float], moving: tuple[int, ...]) -> None:
    box, lid = ((0, 0, 0), (1, 1, 1)), ((0, 1, 0), (1, 1.1, 1))
    shape = prepare_shape(shape_of_boxes([box, lid], (Body(0, "box", (1,)), Body(1, "lid", (2,), 0, HINGE))), points=64)

    def moves(bodies: list[tuple[int, ...]], rest: tuple[float, float]) -> tuple[int, ...]:
        answers = ranked_bodies(shape, None, bodies, Undecided(rest), all_fixed(shape), rests="first")
        return tuple(index for index, found in enumerate(answers) if found[0].joint is not None)

    assert moves([(0,), (1,)], rest) == (1,)
    # nothing was left to rest on: the part that most likely rests does
    assert moves([(), (0,), (1,)], rest) == ((1,) if rest[1] > rest[0] else moving)


def test_every_leaf_belongs_to_exactly_one_body() -> None:
    shape = cabinet(3)
    first, _ = moving_pair(shape)
    bodies = predicted_bodies(shape, {first: SLIDE}, all_fixed(shape))
    assert sorted(leaf for body in bodies for leaf in body) == list(range(len(shape.leaves)))
    assert bodies[1] == shape.leaves_below[first]


def test_siblings_that_touch_and_move_alike_are_one_body() -> None:
    shape = touching(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    assert len(predicted_bodies(shape, {first: SLIDE, second: SLIDE}, all_fixed(shape))) == 2


def test_siblings_that_move_otherwise_or_stand_apart_are_two() -> None:
    shape = touching(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    assert len(predicted_bodies(shape, {first: SLIDE, second: LIFT}, all_fixed(shape))) == 3
    assert len(predicted_bodies(touching(shape, 0.1), {first: SLIDE, second: SLIDE}, all_fixed(shape))) == 3


def test_siblings_that_are_alike_are_two_such_as_the_keys_of_a_keypad() -> None:
    shape = touching(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    sizes = shape.minimum_boxes.half_extents.copy()
    sizes[first] = 1.05 * sizes[second][[2, 0, 1]]
    alike = replace(shape, minimum_boxes=replace(shape.minimum_boxes, half_extents=sizes))
    assert len(predicted_bodies(alike, {first: SLIDE, second: SLIDE}, all_fixed(alike))) == 3


def test_a_shaft_is_one_body_with_what_turns_about_its_line_whatever_the_gnn_says() -> None:
    shape = touching(cabinet(3), 0.0)
    first, second = moving_pair(shape)
    turning = {first: HINGE, second: HINGE}
    on_the_line = (HINGE.pivot + [0.0, 0.4, 0.0]).tolist()
    shaft = with_box(shape, first, on_the_line, [0.01, 0.3, 0.01])
    assert len(predicted_bodies(shaft, turning, none_fixed(shaft))) == 2
    hand_on_a_pin = with_box(shape, first, on_the_line, [0.3, 0.01, 0.01])
    assert len(predicted_bodies(hand_on_a_pin, turning, none_fixed(hand_on_a_pin))) == 3
    beside_the_line = with_box(shape, first, [0.4, 0.4, 0.1], [0.01, 0.3, 0.01])
    assert len(predicted_bodies(beside_the_line, turning, none_fixed(beside_the_line))) == 3


def test_what_moves_inside_a_moving_node_is_a_body_of_its_own() -> None:
    shape = cabinet(3)
    first, _ = moving_pair(shape)
    node = shape.parents[first]
    bodies = predicted_bodies(shape, {node: SLIDE, first: HINGE}, all_fixed(shape))
    assert len(bodies) == 3
    assert set(bodies[1]) == set(shape.leaves_below[node]) - set(shape.leaves_below[first])


def test_joints_are_the_same_whatever_their_sense_and_the_pivot_along_the_axis() -> None:
    slid = replace(HINGE.reversed(), pivot=HINGE.pivot + 7.0 * HINGE.direction)
    assert same_joint(HINGE, slid)
    assert not same_joint(HINGE, replace(HINGE, pivot=HINGE.pivot + [0.06, 0.0, 0.0]))
    assert not same_joint(HINGE, LIFT)
    assert same_joint(SLIDE, replace(SLIDE, pivot=np.ones(3)))
