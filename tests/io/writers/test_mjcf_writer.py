"""The MJCF writer."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.io.writers import ExportOptions, write_formats


def test_every_body_has_a_mass_as_old_versions_of_mujoco_ask(tmp_path):
    hinge = Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), 0.0, 1.5)
    boxes = [((0, 0, 0), (1, 2, 1)), ((0, 0, 1.01), (1, 2, 1.1))]
    shape = shape_of_boxes(boxes, (Body(0, "body", (1,)), Body(1, "door", (2,), 0, hinge)))
    path = write_formats(shape, shape.mobility, tmp_path, ["mjcf"], ExportOptions(collision="none"))["mjcf"]
    bodies = list(ET.parse(path).iter("body"))
    assert [body.get("name") for body in bodies] == ["base", "door"]
    assert all(float(body.find("inertial").get("mass")) > 0.0 for body in bodies)
