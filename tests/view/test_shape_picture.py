"""Pictures of objects are well-formed and self-contained, with axes where joints are."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np

from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Mesh
from kinmo.view.picture_raster import front_left
from kinmo.view.shape_picture import Axis, object_picture

UP = np.array([0.0, 1.0, 0.0])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4],
                  [1, 5, 7], [1, 7, 3]], np.uint32)  # fmt: skip


def cuboid(low: list[float], high: list[float]) -> Mesh:
    ends = np.array([low, high], float)
    return Mesh(np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]), FACES)


BODY, DOOR = cuboid([-1, -1, -1], [1, 1, 0.8]), cuboid([-1, -1, 0.8], [1, 1, 1])
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([-1.0, 0.3, 0.9]))


def draw(*axes: Axis) -> ElementTree.Element:
    return ElementTree.fromstring(object_picture((BODY, DOOR), frozenset({1}), axes, UP, 'a "door" & <frame>'))


def test_the_picture_is_well_formed_and_carries_its_pixels() -> None:
    svg = draw()
    assert svg.attrib["aria-label"] == 'a "door" & <frame>'
    image = svg.find("image")
    assert image is not None and image.attrib["href"].startswith("data:image/png;base64,")


def test_a_hinge_is_drawn_on_its_axis_whatever_its_pivot() -> None:
    moved = Joint(HINGE.kind, HINGE.direction, HINGE.pivot + 5.0 * HINGE.direction)
    lines = [[line.attrib for line in draw(Axis(joint, "truth")).iter("line")] for joint in (HINGE, moved)]
    assert lines[0] == lines[1]
    camera = front_left(np.concatenate([BODY.vertices, DOOR.vertices]), UP, 300)
    start, end = (np.array([float(lines[0][0][f"{name}{place}"]) for name in "xy"]) for place in (1, 2))
    along, across = (end - start) / np.linalg.norm(end - start), camera.project(HINGE.pivot) - start
    assert abs(along[0] * across[1] - along[1] * across[0]) < 0.2


def test_a_slider_is_drawn_through_the_middle_of_the_moving_part() -> None:
    slider = Joint(JointKind.PRISMATIC, np.array([1.0, 0.0, 0.0]), np.array([50.0, 50.0, 50.0]))
    line = next(draw(Axis(slider, "refined")).iter("line")).attrib
    assert all(0 <= float(line[name]) <= 300 for name in ("x1", "y1", "x2", "y2"))


def test_each_axis_has_the_style_of_its_role() -> None:
    svg = draw(Axis(HINGE, "truth"), Axis(HINGE.reversed(), "refined"))
    assert {element.attrib["class"] for element in svg.iter("line")} == {"halo", "axis truth", "axis refined"}


def test_an_axis_seen_end_on_is_a_dot() -> None:
    camera = front_left(np.concatenate([BODY.vertices, DOOR.vertices]), UP, 300)
    svg = draw(Axis(Joint(JointKind.REVOLUTE, camera.rotation[2], camera.middle), "truth"))
    assert svg.find("circle") is not None and svg.find("line") is None


def test_the_moving_part_has_its_own_colour() -> None:
    still = object_picture((BODY, DOOR), frozenset(), (), UP, "")
    moving = object_picture((BODY, DOOR), frozenset({1}), (), UP, "")
    assert re.findall('base64,(.*?)"', still) != re.findall('base64,(.*?)"', moving)
