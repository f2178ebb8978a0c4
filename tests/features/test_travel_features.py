"""Features of the travel of joints."""

from __future__ import annotations

import numpy as np
import pytest
from cabinet_geometry import DOOR, DRAWER, FRAME, KNOB, UP, cabinet_geometry
from scipy.spatial.transform import Rotation

from kinmo.core.joint import Joint, JointKind
from kinmo.features.group_geometry import group_geometries
from kinmo.features.travel_features import (
    DIRECTED_FEATURES,
    FREE,
    HINGE_SCALE,
    SHARED_FEATURES,
    TravelFeatures,
    travel_features,
)

HINGE = Joint(JointKind.REVOLUTE, UP, np.array([-0.23, 0.0, 0.155]))
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3))
RISE = 3
OUTWARD = 5


def features_of(group: tuple[int, ...], joints: list[Joint], turn: np.ndarray | None = None) -> TravelFeatures:
    geometry = cabinet_geometry(turn)
    (found,) = group_geometries(geometry, [group])
    return travel_features(geometry, found, group, joints)


def test_a_drawer_is_free_outwards_and_blocked_inwards() -> None:
    found = features_of((DRAWER,), [SLIDE])
    outwards, inwards = found.directed[0, :, FREE]
    assert outwards > 0.9 > 0.3 > inwards
    assert found.directed[0, 0, OUTWARD] > 0 > found.directed[0, 1, OUTWARD]
    assert found.scales[0] == pytest.approx(0.025, rel=0.5), "the depth of the drawer's front"
    assert features_of((DOOR, KNOB), [HINGE]).scales[0] == HINGE_SCALE


def test_a_reversed_joint_exchanges_the_senses() -> None:
    one, other = (features_of((DOOR, KNOB), [joint]) for joint in (HINGE, HINGE.reversed()))
    np.testing.assert_allclose(one.directed, other.directed[:, ::-1], atol=2e-2)
    np.testing.assert_allclose(one.shared, other.shared, atol=2e-2)


def test_features_do_not_change_when_the_object_turns_about_up() -> None:
    turn = Rotation.from_rotvec(0.7 * UP).as_matrix()
    still, turned = features_of((DRAWER,), [SLIDE]), features_of((DRAWER,), [SLIDE.rotated(turn)], turn)
    np.testing.assert_allclose(still.directed, turned.directed, atol=2e-2)
    np.testing.assert_allclose(still.shared, turned.shared, atol=2e-2)


def test_a_lid_rises_in_one_sense() -> None:
    lid = Joint(JointKind.REVOLUTE, np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.23, 0.155]))
    rises = features_of((DRAWER,), [lid]).directed[0, :, RISE]
    assert rises[0] == pytest.approx(-rises[1])


def test_an_object_of_one_body_travels_freely() -> None:
    found = features_of((FRAME, DOOR, KNOB, DRAWER), [HINGE, SLIDE])
    np.testing.assert_allclose(found.directed[:, :, FREE], [[2.0, 2.0], [1.0, 1.0]], atol=1e-6)
    assert found.directed.shape == (2, 2, DIRECTED_FEATURES) and found.shared.shape == (2, SHARED_FEATURES)
    assert np.isfinite(found.directed).all() and np.isfinite(found.shared).all()
