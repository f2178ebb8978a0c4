"""Corrections by hand: grouping, joints, parents and names of a prediction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from articulated import articulated_shapes, shape_of_boxes
from documents import ROOT, code_blocks
from hypothesis import given, settings
from hypothesis import strategies as st
from predicted_cabinet import LEFT, OUT, RIGHT, UP, hinge, slider

from kinmo.core.corrected_estimate import corrected_estimate
from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Body, Mobility, has_cycle
from kinmo.core.motion_types import CoarseType, MotionType
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.core.toml_text import parse_toml
from kinmo.io.readers.overrides_reader import parse_overrides

FRAME, DOOR, KNOB, FRONT, BOX = range(1, 6)
NAMES = {FRAME: "frame", DOOR: "door", KNOB: "knob", FRONT: "front", BOX: "box"}
BODIES = (
    Body(0, "base", (FRAME, BOX)),
    Body(1, "door", (DOOR,), 0, hinge(RIGHT)),
    Body(2, "knob", (KNOB,), 1, hinge(LEFT)),
    Body(3, "front", (FRONT,), 0, slider()),
)
OF_DOOR = (
    JointEstimate(hinge(RIGHT), MotionType.R_V_S, 0.4),
    JointEstimate(hinge(LEFT), MotionType.R_V_S, 0.3),
    JointEstimate(slider(), MotionType.P_H, 0.2),
    JointEstimate(None, MotionType.FIXED, 0.1),
)


def cabinet(bodies: tuple[Body, ...] = BODIES, names: dict[int, str] = NAMES) -> tuple[Shape, ShapeEstimate]:
    """A cabinet of five boxes, and a prediction for it."""
    boxes = [((i, 0, 0), (i + 1, 1, 1)) for i in range(5)]
    shape = shape_of_boxes(boxes, bodies, names=names)
    ranked = tuple(OF_DOOR if body.name == "door" else (JointEstimate(body.joint, MotionType.FIXED, 0.5),) for body in bodies)
    estimate = ShapeEstimate(shape.id, shape.category, Mobility(bodies), ranked, tuple(each[0] for each in ranked), "kinmo")
    return shape, estimate


def corrected(bodies: dict[str, Any] | None = None, new: dict[str, Any] | None = None) -> ShapeEstimate:
    shape, estimate = cabinet()
    return corrected_estimate(shape, estimate, parse_overrides({"bodies": bodies or {}, "new_bodies": new or {}}, Path("o")))


def body_of(estimate: ShapeEstimate, name: str) -> Body:
    (body,) = (body for body in estimate.mobility.bodies if body.name == name)
    return body


def joint_of(estimate: ShapeEstimate, name: str) -> Joint:
    joint = body_of(estimate, name).joint
    assert joint is not None
    return joint


def parent_of(estimate: ShapeEstimate, name: str) -> str | None:
    parent = body_of(estimate, name).parent
    return None if parent is None else estimate.mobility.bodies[parent].name


def test_no_overrides_change_nothing_but_mark_the_prediction_as_checked() -> None:
    _, estimate = cabinet()
    found = corrected()
    for body, expected in zip(found.mobility.bodies, estimate.mobility.bodies, strict=True):
        assert (body.id, body.name, body.leaves, body.parent) == (expected.id, expected.name, expected.leaves, expected.parent)
        assert body.joint is expected.joint
    assert found.correction is not None and found.correction.notes == ()
    assert found.estimates == found.correction.predicted.estimates


def test_a_corrected_joint_has_score_1_and_keeps_the_alternatives() -> None:
    found = corrected({"door": {"range": [0, 110]}})
    best, *others = found.estimates[1]
    assert (best.source, best.score, best.type) == ("override", 1.0, CoarseType.R)
    assert tuple(others) == OF_DOOR
    assert best.joint is found.mobility.bodies[1].joint
    assert [ranked[0].source for ranked in found.estimates].count("override") == 1


def test_a_range_is_in_degrees_for_a_hinge_and_in_lengths_for_a_slider() -> None:
    found = corrected({"door": {"range": [-10, 110]}, "front": {"range": [0, 0.3]}})
    door, front = joint_of(found, "door"), joint_of(found, "front")
    assert (door.lower, door.upper, door.rest) == pytest.approx((math.radians(-10), math.radians(110), 0.0))
    assert (front.lower, front.upper, front.rest) == (0.0, 0.3, 0.0)
    assert not joint_of(corrected({"door": {"range": "unlimited"}}), "door").is_limited


def test_axis_and_origin_are_those_that_are_given() -> None:
    door = joint_of(corrected({"door": {"axis": [0, 0, -3], "origin": [1, 2, 3]}}), "door")
    assert door.direction == pytest.approx([0, 0, -1])
    assert door.pivot == pytest.approx([1, 2, 3])
    assert (door.kind, door.upper) == (JointKind.REVOLUTE, math.pi / 2)


def test_a_flipped_joint_opens_the_other_way() -> None:
    door = joint_of(corrected({"door": {"flip": True}}), "door")
    assert door.direction == pytest.approx(-UP)
    assert (door.lower, door.upper) == (0.0, math.pi / 2)
    assert joint_of(corrected({"door": {"flip": False}}), "door").direction == pytest.approx(UP)


def test_an_alternative_is_counted_from_1() -> None:
    second = joint_of(corrected({"door": {"alternative": 2}}), "door")
    assert second.kind is JointKind.REVOLUTE and second.pivot == pytest.approx(LEFT)
    assert joint_of(corrected({"door": {"alternative": 3}}), "door").kind is JointKind.PRISMATIC
    fixed = corrected({"door": {"alternative": 4}})
    assert body_of(fixed, "door").joint is None and parent_of(fixed, "door") == "base"


def test_a_new_type_takes_the_best_ranked_joint_of_that_type() -> None:
    door = joint_of(corrected({"door": {"type": "slider"}}), "door")
    assert door.kind is JointKind.PRISMATIC and door.direction == pytest.approx(OUT) and door.upper == 0.2
    assert body_of(corrected({"door": {"type": "fixed"}}), "door").joint is None


def test_parts_move_between_bodies_and_empty_bodies_disappear() -> None:
    found = corrected({"door": {"parts": ["door", "knob"]}, "front": {"parts": ["front", "box"], "name": "drawer"}})
    assert [(body.id, body.name, body.leaves) for body in found.mobility.bodies] == [
        (0, "base", (FRAME,)),
        (1, "door", (DOOR, KNOB)),
        (3, "drawer", (FRONT, BOX)),
    ]
    assert found.correction is not None
    assert found.correction.notes == ("knob has no part left: dropped",)


def test_children_of_a_body_that_disappears_move_up() -> None:
    found = corrected({"base": {"parts": ["frame", "box", "door"]}})
    assert parent_of(found, "knob") == "base"


def test_parts_that_a_body_gives_up_go_to_its_parent() -> None:
    found = corrected({"knob": {"parts": []}})
    assert body_of(found, "door").leaves == (DOOR, KNOB)
    assert found.correction is not None
    assert found.correction.notes == ("part 3 (knob) of knob goes to door", "knob has no part left: dropped")


def test_a_new_body_takes_its_parts_from_others_and_hangs_at_the_base() -> None:
    lid = {"parts": ["box"], "type": "hinge", "axis": [1, 0, 0], "origin": [0, 0, 0], "range": [0, 90]}
    found = corrected(new={"lid": lid})
    assert (body_of(found, "lid").id, body_of(found, "lid").leaves, parent_of(found, "lid")) == (4, (BOX,), "base")
    assert found.estimates[-1][0].source == "override" and len(found.estimates[-1]) == 1
    assert body_of(found, "base").leaves == (FRAME,)
    tray = {"parts": ["box"], "type": "slider", "axis": [1, 0, 0], "range": [0, 1], "parent": "front"}
    found = corrected(new={"tray": tray})
    assert parent_of(found, "tray") == "front"
    assert joint_of(found, "tray").pivot == pytest.approx([4.5, 0.5, 0.5]), "the centre of the body"


def test_parents_are_named_by_old_names_new_names_and_numbers() -> None:
    for parent in ("front", "drawer", 3, "3", "#3"):
        found = corrected({"knob": {"parent": parent}, "front": {"name": "drawer"}})
        assert parent_of(found, "knob") == "drawer"
    assert parent_of(corrected({"knob": {"parent": "base"}}), "knob") == "base"


def test_a_root_that_moves_hangs_at_another_root() -> None:
    bodies = (*BODIES[:3], Body(3, "front", (FRONT,)))
    shape, estimate = cabinet(bodies)
    table = {"bodies": {"front": {"type": "slider", "axis": [0, 0, 1], "range": [0, 1]}}}
    found = corrected_estimate(shape, estimate, parse_overrides(table, Path("o")))
    assert parent_of(found, "front") == "base"


def test_a_correction_replaces_an_earlier_one() -> None:
    shape, _ = cabinet()
    first = corrected({"door": {"flip": True, "name": "left"}})
    again = corrected_estimate(shape, first, parse_overrides({"bodies": {"door": {"flip": True}}}, Path("o")))
    assert joint_of(again, "door").direction == pytest.approx(-UP)
    assert again.correction is not None and first.correction is not None
    assert again.correction.predicted is first.correction.predicted


@pytest.mark.parametrize(
    ("bodies", "new", "message"),
    [
        (
            {"dor": {"flip": True}},
            {},
            r"bodies\.dor: there is no body dor \(did you mean door\?\); there are base, door, knob,",
        ),
        ({"door": {"parent": "front"}, "1": {}}, {}, r"bodies\.1: is the same body as bodies\.door"),
        ({"door": {"parent": "lid"}}, {}, r"bodies\.door\.parent: there is no body lid"),
        ({"door": {"parent": "knob"}}, {}, r"bodies\.door\.parent: the parents form a cycle: door -> knob -> door"),
        ({"door": {"parent": "door"}}, {}, "the parents form a cycle: door -> door"),
        ({"door": {"parts": ["dor"]}}, {}, r"bodies\.door\.parts\[0\]: there is no part dor \(did you mean door\?\)"),
        ({"door": {"parts": ["door", 9]}}, {}, r"bodies\.door\.parts\[1\]: there is no part 9; there are frame, door"),
        ({"door": {"parts": ["box"]}, "front": {"parts": ["box"]}}, {}, r"part 5 \(box\) is listed for door too"),
        ({"base": {"parts": ["frame"]}}, {}, r"bodies\.base\.parts: part 5 \(box\) would belong to no body"),
        ({"door": {"alternative": 5}}, {}, r"bodies\.door\.alternative: expected 1 to 4"),
        ({"door": {"alternative": 2, "type": "slider"}}, {}, r"bodies\.door\.type: joint 2 of the ranking is hinge"),
        (
            {"door": {"type": "screw"}},
            {},
            r"bodies\.door\.axis: needed, with origin and range, because no ranked joint of the body is a screw",
        ),
        ({"front": {"type": "hinge", "axis": [0, 1, 0], "range": [0, 9]}}, {}, r"bodies\.front\.origin: needed"),
        ({"door": {"type": "fixed", "axis": [0, 1, 0]}}, {}, r"bodies\.door\.axis: a fixed body has no joint"),
        ({"door": {"origin": [0, 1e6, 0]}}, {}, r"bodies\.door\.origin: expected a point within 100 diagonals"),
        ({"door": {"range": [0, 1e6]}}, {}, r"bodies\.door\.range: expected degrees within 100 turns"),
        ({"front": {"range": [0, 1e6]}}, {}, r"bodies\.front\.range: expected lengths of at most"),
        ({"base": {"flip": True}}, {}, r"bodies\.base\.type: needed, because the body is fixed"),
        ({"knob": {"parts": []}, "front": {"parent": "knob"}}, {}, r"bodies\.front\.parent: knob has no part left"),
        (
            {"base": {"type": "slider", "axis": [0, 0, 1], "range": [0, 1]}},
            {},
            r"bodies\.base\.parent: needed, because no body is left that rests",
        ),
        ({}, {"door": {"parts": ["box"], "type": "fixed"}}, r"new_bodies\.door: there is a body of this name"),
        ({}, {"lid": {"parts": ["box"], "type": "slider", "range": [0, 1]}}, r"new_bodies\.lid\.axis: needed"),
    ],
)
def test_what_cannot_be_done_is_one_line_with_the_field(bodies: dict, new: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        corrected(bodies, new)


def test_bodies_and_parts_of_the_same_name_are_named_by_number() -> None:
    bodies = tuple(Body(b.id, "door" if b.joint else "base", b.leaves, b.parent, b.joint) for b in BODIES)
    shape, estimate = cabinet(bodies, dict.fromkeys(NAMES, "Cube"))

    def correct(table: dict[str, Any]) -> ShapeEstimate:
        return corrected_estimate(shape, estimate, parse_overrides(table, Path("o")))

    with pytest.raises(InputError, match='3 bodies are called door: write "#1", "#2" or "#3"'):
        correct({"bodies": {"door": {"flip": True}}})
    with pytest.raises(InputError, match="5 parts are called Cube: write 1, 2, 3, 4 or 5 without quotes"):
        correct({"bodies": {"#1": {"parts": ["Cube"]}}})
    assert correct({"bodies": {"#1": {"parts": [DOOR, KNOB]}}}).mobility.bodies[1].leaves == (DOOR, KNOB)
    renamed = correct({"bodies": {"2": {"name": "knob"}}})
    assert [body.name for body in renamed.mobility.bodies] == ["base", "door", "knob", "door"]
    links = {link.name: link.body for link in links_of(estimate.mobility)}
    linked = correct({"bodies": {"door_2": {"name": "knob"}}})
    assert [place for place, body in enumerate(linked.mobility.bodies) if body.name == "knob"] == [links["door_2"]]
    taken = correct({"bodies": {"1": {"parts": [DOOR, KNOB]}}})
    assert taken.correction is not None and taken.correction.notes == ("door #2 has no part left: dropped",)
    with pytest.raises(InputError, match="cycle: door #1 -> door #2 -> door #1"):
        correct({"bodies": {"1": {"parent": 2}}})


def test_corrections_of_a_body_that_disappears_are_noted() -> None:
    found = corrected({"door": {"parts": ["door", "knob"]}, "knob": {"type": "fixed"}})
    assert found.correction is not None
    assert found.correction.notes == ("knob has no part left: dropped, with its corrections",)


def test_bodies_that_nobody_corrects_stay_without_a_parent() -> None:
    bodies = (Body(0, "base", (FRAME, BOX)), Body(1, "door", (DOOR, KNOB, FRONT), None, hinge(RIGHT)))
    shape, estimate = cabinet(bodies)
    found = corrected_estimate(shape, estimate, parse_overrides({"bodies": {"base": {"name": "frame"}}}, Path("o")))
    assert [body.parent for body in found.mobility.bodies] == [None, None]
    found = corrected_estimate(shape, estimate, parse_overrides({"bodies": {"door": {"range": [0, 9]}}}, Path("o")))
    assert [body.parent for body in found.mobility.bodies] == [None, 0]


def test_what_a_dropped_base_carried_moves_to_the_largest_body_that_rests() -> None:
    found = corrected({"front": {"parts": ["frame", "box", "front"], "type": "fixed"}})
    base, door = body_of(found, "front"), body_of(found, "door")
    assert base.joint is None and base.parent is None
    assert door.joint is not None and door.parent is not None
    assert found.mobility.bodies[door.parent].name == "front"


def prediction_for(shape: Shape) -> ShapeEstimate:
    assert shape.mobility is not None
    ranked = tuple((JointEstimate(body.joint, MotionType.R_V_S, 0.5),) for body in shape.mobility.bodies)
    return ShapeEstimate(shape.id, shape.category, shape.mobility, ranked, tuple(each[0] for each in ranked), "kinmo")


@settings(max_examples=150)
@given(articulated_shapes(), st.data())
def test_any_grouping_gives_a_tree_of_bodies_with_every_part_in_one(shape: Shape, data: st.DataObject) -> None:
    estimate = prediction_for(shape)
    numbers = [body.id for body in estimate.mobility.bodies]
    ids = [shape.parts[leaf].id for leaf in shape.leaves]
    owner = {part: data.draw(st.sampled_from([*numbers, None])) for part in ids}
    listed = {number for number in owner.values() if number is not None}
    parents = {number: data.draw(st.sampled_from([*numbers, None])) for number in listed}
    table = {
        f"#{number}": {"parts": [part for part, own in owner.items() if own == number]}
        | ({} if parents[number] is None else {"parent": parents[number]})
        for number in listed
    }
    try:
        found = corrected_estimate(shape, estimate, parse_overrides({"bodies": table}, Path("o")))
    except InputError as error:
        assert "\n" not in str(error) and str(error).startswith("o: bodies.")
        return
    bodies = found.mobility.bodies
    assert sorted(leaf for body in bodies for leaf in body.leaves) == sorted(shape.leaves)
    assert not has_cycle([body.parent for body in bodies])
    rootless = {body.id for body in estimate.mobility.bodies if body.parent is None} - listed
    rests = any(body.parent is None and body.joint is None for body in bodies)
    for body in bodies:
        assert body.joint is None or body.parent is not None or body.id in rootless or not rests
    assert len(found.estimates) == len(found.gnn_estimates) == len(bodies)
    leaf_of = {shape.parts[leaf].id: leaf for leaf in shape.leaves}
    for body in bodies:
        wanted = {leaf_of[part] for part, own in owner.items() if own == body.id}
        assert wanted == set(body.leaves) if body.id in listed else wanted <= set(body.leaves)


@settings(max_examples=40)
@given(articulated_shapes())
def test_the_present_axis_and_range_given_by_hand_give_the_same_joint(shape: Shape) -> None:
    estimate = prediction_for(shape)
    table = {}
    for index, body in estimate.mobility.movable():
        joint = body.joint
        assert joint is not None
        degrees = 180.0 / math.pi if joint.kind is JointKind.REVOLUTE else 1.0
        limits: Any = "unlimited"
        if joint.lower is not None and joint.upper is not None:
            if not joint.lower <= 0.0 <= joint.upper or joint.upper * degrees - joint.lower * degrees <= 0.0:
                continue
            limits = [joint.lower * degrees, joint.upper * degrees]
        table[f"#{index}"] = {"axis": 2.0 * joint.direction, "origin": joint.pivot, "range": limits}
    found = corrected_estimate(shape, estimate, parse_overrides({"bodies": table}, Path("o")))
    for body, expected in zip(found.mobility.bodies, estimate.mobility.bodies, strict=True):
        assert (body.joint is None) == (expected.joint is None)
        if body.joint is not None and expected.joint is not None:
            np.testing.assert_allclose(body.joint.direction, expected.joint.direction, atol=1e-12)
            np.testing.assert_allclose(body.joint.pivot, expected.joint.pivot)
            assert body.joint.kind is expected.joint.kind
            assert body.joint.lower == (
                None if expected.joint.lower is None else pytest.approx(expected.joint.lower, abs=1e-12)
            )


def test_a_rotated_correction_is_in_the_same_frame() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    found = corrected({"door": {"flip": True}}).rotated(turn)
    assert joint_of(found, "door").direction == pytest.approx(turn @ -UP)
    assert joint_of(found.predicted, "door").direction == pytest.approx(turn @ UP)


def test_the_example_of_the_guide_applies() -> None:
    names = dict(enumerate(("frame", "door_left", "knob_left", "drawer", "lid", "shelf", "back"), 1))
    bodies = (
        Body(0, "base", (1, 6, 7)),
        Body(1, "door_left", (2, 3), 0, hinge(RIGHT)),
        Body(2, "drawer", (4,), 0, slider()),
        Body(3, "lid", (5,), 0, hinge(LEFT)),
    )
    shape = shape_of_boxes([((i, 0, 0), (i + 1, 1, 1)) for i in range(7)], bodies, names=names)
    ranked = tuple((JointEstimate(body.joint, MotionType.FIXED, 0.5), *OF_DOOR[2:]) for body in bodies)
    estimate = ShapeEstimate(shape.id, shape.category, Mobility(bodies), ranked, (), "kinmo")
    (example,) = code_blocks(ROOT / "docs" / "guide" / "correct.md", "toml")
    table = parse_toml(example.encode(), Path("overrides.toml"))
    assert {key for body in table["bodies"].values() for key in body} == {
        *("type", "axis", "origin", "range", "parent", "parts", "name", "alternative", "flip")
    }
    found = corrected_estimate(shape, estimate, parse_overrides(table, Path("overrides.toml")))
    assert [body.name for body in found.mobility.bodies] == ["base", "door_left", "top_drawer", "lid", "knob"]
    assert joint_of(found, "door_left").upper == pytest.approx(math.radians(110.0))
    np.testing.assert_allclose(joint_of(found, "lid").direction, [1.0, 0.0, 0.0])
    assert not joint_of(found, "knob").is_limited and parent_of(found, "knob") == "door_left"
