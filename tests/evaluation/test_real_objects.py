"""Real objects written and read again: the exported truth has no errors."""

import pybullet
import pytest
from exports import write_partnet_mobility, write_urdf

from kinmo.core.joint import JointKind
from kinmo.core.links import links_of
from kinmo.evaluation.urdf_scoring import score_urdf
from kinmo.io.readers import read_partnet_mobility

pytestmark = pytest.mark.real
EVERY = 48
"""One in this many real objects is tested."""


@pytest.fixture(scope="module")
def shapes(real_objects):
    return [read_partnet_mobility(folder) for folder in real_objects[::EVERY]]


def test_the_truth_as_a_urdf_has_no_errors(shapes, tmp_path):
    for shape in shapes:
        score = score_urdf(shape, write_urdf(shape, shape.mobility, tmp_path / shape.id), tmp_path)
        assert (score.status, score.false_alarms) == ("scored", 0)
        for part in score.parts:
            assert part.kind_ok
            assert part.parent_ok
            assert part.angle < 1e-9
            assert part.line is None or part.line < 1e-9
            assert part.range_iou is None or part.range_iou == pytest.approx(1)


def test_a_simulator_loads_the_urdf_with_all_its_joints(shapes, tmp_path):
    client = pybullet.connect(pybullet.DIRECT)
    for shape in shapes:
        path = write_urdf(shape, shape.mobility, tmp_path / shape.id)
        robot = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
        joints = [link.joint for link in links_of(shape.mobility) if link.joint is not None]
        screws = sum(joint.kind is JointKind.SCREW for joint in joints)
        assert pybullet.getNumJoints(robot, physicsClientId=client) == len(joints) + screws
    pybullet.disconnect(client)


def test_written_labels_are_read_unchanged(shapes, tmp_path):
    for shape in shapes:
        found = read_partnet_mobility(write_partnet_mobility(shape, shape.mobility, tmp_path / shape.id))
        assert found.category == shape.category
        for body, written in zip(found.mobility.bodies, shape.mobility.bodies, strict=True):
            assert (body.leaves, body.parent) == (written.leaves, written.parent)
            assert (body.joint is None) == (written.joint is None)
            if body.joint is not None:
                assert body.joint.kind is written.joint.kind
                assert body.joint.direction == pytest.approx(written.joint.direction)
                assert body.joint.lower == pytest.approx(written.joint.lower)
