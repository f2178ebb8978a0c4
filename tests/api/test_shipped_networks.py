"""The networks that come with kinmo, on cabinets of boards with doors and drawers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import shape_of_boxes

import kinmo
from kinmo.core.joint import JointKind
from kinmo.core.shape import Shape
from kinmo.learning.model_folder import SHIPPED

Box = tuple[tuple[float, float, float], tuple[float, float, float]]
Body = tuple[JointKind, frozenset[str]]

CARCASS: dict[str, Box] = {
    "back": ((-0.4, 0.0, -0.25), (0.4, 1.2, -0.23)),
    "left_side": ((-0.4, 0.0, -0.23), (-0.38, 1.2, 0.23)),
    "right_side": ((0.38, 0.0, -0.23), (0.4, 1.2, 0.23)),
    "bottom": ((-0.38, 0.0, -0.23), (0.38, 0.02, 0.23)),
    "top": ((-0.38, 1.18, -0.23), (0.38, 1.2, 0.23)),
    "shelf": ((-0.38, 0.78, -0.23), (0.38, 0.8, 0.23)),
}
LEFT: dict[str, Box] = {
    "left_door": ((-0.4, 0.0, 0.23), (-0.002, 0.79, 0.25)),
    "left_handle": ((-0.06, 0.33, 0.25), (-0.04, 0.53, 0.28)),
}
RIGHT: dict[str, Box] = {
    "right_door": ((0.002, 0.0, 0.23), (0.4, 0.79, 0.25)),
    "right_handle": ((0.04, 0.33, 0.25), (0.06, 0.53, 0.28)),
}
DRAWER: dict[str, Box] = {
    "front": ((-0.4, 0.8, 0.23), (0.4, 1.2, 0.25)),
    "drawer_left": ((-0.36, 0.82, -0.2), (-0.345, 1.1, 0.23)),
    "drawer_right": ((0.345, 0.82, -0.2), (0.36, 1.1, 0.23)),
    "drawer_back": ((-0.345, 0.82, -0.2), (0.345, 1.1, -0.185)),
    "drawer_bottom": ((-0.345, 0.82, -0.185), (0.345, 0.835, 0.23)),
    "handle": ((-0.1, 0.99, 0.25), (0.1, 1.01, 0.28)),
}
EXPECTED: set[Body] = {
    (JointKind.REVOLUTE, frozenset(LEFT)),
    (JointKind.REVOLUTE, frozenset(RIGHT)),
    (JointKind.PRISMATIC, frozenset(DRAWER)),
}
PARTS = {**CARCASS, **LEFT, **RIGHT, **DRAWER}


@pytest.fixture(scope="module")
def predictor(tmp_path_factory: pytest.TempPathFactory) -> kinmo.Predictor:
    return kinmo.Predictor(tmp_path_factory.mktemp("nothing") / "workspace", device="cpu")


def cabinet(order: list[str], names: dict[str, str] | None = None) -> Shape:
    """The cabinet with its parts in some order, called `Cube.001` and so on unless they have names."""
    called = {place: (names or {}).get(part, f"Cube.{place:03}") for place, part in enumerate(order, start=1)}
    return replace(shape_of_boxes([PARTS[part] for part in order], (), category="", names=called), mobility=None)


def without_names(parts: Mapping[str, Box]) -> Shape:
    """A shape whose parts are all called `Cube`."""
    names = dict.fromkeys(range(1, len(parts) + 1), "Cube")
    return replace(shape_of_boxes(list(parts.values()), (), category="", names=names), mobility=None)


def moving(prediction: kinmo.Prediction, order: list[str]) -> set[Body]:
    """Joint kind and parts of every body that moves."""
    mobility = prediction.estimate.mobility
    return {
        (body.joint.kind, frozenset(order[leaf - 1] for leaf in body.leaves))
        for _, body in mobility.movable()
        if body.joint is not None
    }


def test_doors_turn_at_their_outer_sides_and_the_drawer_slides_forward(predictor: kinmo.Predictor) -> None:
    order = list(PARTS)
    prediction = predictor.predict(cabinet(order))
    assert moving(prediction, order) == EXPECTED
    for _, body in prediction.estimate.mobility.movable():
        joint = body.joint
        assert joint is not None and joint.lower is not None and joint.upper is not None
        if joint.kind is JointKind.PRISMATIC:
            assert joint.direction == pytest.approx([0, 0, 1], abs=0.02)
            assert joint.lower == pytest.approx(0.0, abs=0.02) and joint.upper > 0.15
        else:
            assert abs(joint.direction[1]) == pytest.approx(1.0, abs=0.02)
            assert abs(joint.pivot[0]) == pytest.approx(0.39, abs=0.03)
            assert joint.lower == pytest.approx(0.0, abs=0.1) and joint.upper > 1.0
            side = np.sign(joint.pivot[0])
            outwards = np.cross(joint.direction, np.array([-side * 0.4, 0.0, 0.0]))
            assert outwards[2] > 0, "doors open outwards"


def test_names_and_the_order_of_parts_do_not_matter(predictor: kinmo.Predictor) -> None:
    order = np.random.default_rng(3).permutation(list(PARTS)).tolist()
    assert moving(predictor.predict(replace(cabinet(order), id="Refrigerator")), order) == EXPECTED
    assert moving(predictor.predict(cabinet(order, {part: part for part in order})), order) == EXPECTED
    foreign = {part: f"ящик {place}" if part in DRAWER else f"часть {place}" for place, part in enumerate(order)}
    assert moving(predictor.predict(cabinet(order, foreign)), order) == EXPECTED


def test_a_turned_object_has_the_same_joints(predictor: kinmo.Predictor) -> None:
    order = list(PARTS)
    quarter = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    turned = cabinet(order).rotated(quarter)
    assert turned.front == pytest.approx((1.0, 0.0, 0.0))
    assert moving(predictor.predict(turned), order) == EXPECTED


def test_screws_do_not_become_joints(predictor: kinmo.Predictor) -> None:
    screws = {f"screw {x} {y}": ((x, y, 0.25), (x + 0.006, y + 0.006, 0.253)) for x in (-0.39, 0.38) for y in (0.02, 0.7)}
    found = moving(predictor.predict(without_names({**PARTS, **screws})), [*PARTS, *screws])
    assert {(kind, parts.difference(screws)) for kind, parts in found} == EXPECTED


def test_drawers_with_no_board_between_them_slide_forward(predictor: kinmo.Predictor) -> None:
    boards = {name: box for name, box in CARCASS.items() if name != "shelf"}
    drawers = [
        {f"{part} {floor}": tuple((x, y + 0.4 * floor - 0.8, z) for x, y, z in box) for part, box in DRAWER.items()}
        for floor in range(3)
    ]
    chest = {**boards, **drawers[0], **drawers[1], **drawers[2]}
    found = moving(predictor.predict(without_names(chest)), list(chest))
    assert found == {(JointKind.PRISMATIC, frozenset(drawer)) for drawer in drawers}


def test_they_say_that_they_come_with_kinmo(predictor: kinmo.Predictor) -> None:
    assert predictor.networks == "those that come with kinmo"
    assert sum(path.stat().st_size for path in Path(SHIPPED).rglob("*") if path.is_file()) < 20e6
