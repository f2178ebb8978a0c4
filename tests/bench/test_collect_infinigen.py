"""Joints of Infinigen's URDF exporter."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

import collect_infinigen

NAMES = {"link_0": "body_link_0", "link_1": "door_link_1"}


def connection(kind, limits):
    text = f"""<joint name="j" type="{kind}"><origin xyz="1 2 3"/><parent link="link_0"/><child link="link_1"/>
        <axis xyz="0 0 -0.25"/><limit lower="{limits[0]}" upper="{limits[1]}"/></joint>"""
    return collect_infinigen._connection(ET.fromstring(text), NAMES)


def test_axes_become_unit_vectors():
    joint = connection("revolute", (0.0, 1.5))
    np.testing.assert_allclose(joint.axis, (0, 0, -1))
    assert (joint.parent, joint.child, joint.limits) == ("body_link_0", "door_link_1", (0.0, 1.5))


def test_default_ranges_are_no_limits():
    assert connection("revolute", (-np.pi, np.pi)).limits is None
    assert connection("revolute", (-np.pi, np.pi)).kind == "continuous"
    assert connection("prismatic", (-100, 100)).limits is None
