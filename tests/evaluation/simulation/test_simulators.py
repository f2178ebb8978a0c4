"""MuJoCo and PyBullet load, rest and drive small objects alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from articulated import shape_of_boxes

from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.evaluation.simulation.expected_kinematics import expected_kinematics
from kinmo.evaluation.simulation.object_check import check_object
from kinmo.evaluation.simulation.simulator import LoadError, Simulator
from kinmo.io.writers import ExportOptions, export
from kinmo.robot.physics import Physics

BASE, DOOR = ((0.0, 0.0, 0.0), (1.0, 1.0, 0.5)), ((0.0, 0.0, 0.6), (1.0, 1.0, 0.62))
HINGE = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 0.61]), -1.5, 0.0)
SLIDE = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, 0.5)


@pytest.fixture(params=["mujoco", "pybullet"])
def load(request: pytest.FixtureRequest):
    """A function that loads a URDF into a simulator."""
    pytest.importorskip(request.param)
    if request.param == "mujoco":
        from kinmo.evaluation.simulation.mujoco_simulator import MujocoSimulator as Loaded
    else:
        from kinmo.evaluation.simulation.pybullet_simulator import PybulletSimulator as Loaded
    return Loaded


def shape_with(*joints: Joint, walls=()):
    """A box with a front for each joint, and walls that belong to the box."""
    first = 2 + len(joints)
    bodies = [Body(0, "base", (1, *range(first, first + len(walls))))]
    bodies += [Body(index, f"front {index}", (index + 1,), 0, joint) for index, joint in enumerate(joints, 1)]
    return shape_of_boxes([BASE, *[DOOR] * len(joints), *walls], bodies)


def urdf_of(shape, folder: Path, collision: str = "hull") -> Path:
    return export(shape, shape.mobility, folder / "out", ["urdf"], ExportOptions(collision=collision))["urdf"]


@pytest.mark.parametrize("joint", [HINGE, SLIDE], ids=["hinge", "slider"])
def test_a_front_works(tmp_path, load, joint: Joint) -> None:
    shape = shape_with(joint)
    kinematics = expected_kinematics(shape.mobility, np.array(shape.up), 1.0)
    check = check_object("", load(urdf_of(shape, tmp_path)), kinematics, shape.diagonal)
    assert check.works, check.problems


def test_an_object_without_joints_rests(tmp_path, load) -> None:
    simulator: Simulator = load(urdf_of(shape_with(), tmp_path))
    assert len(simulator.joints) == 0
    record = simulator.rest(0.1)
    assert record.is_finite and record.penetration == 0.0


def test_a_wall_stops_a_driven_joint(tmp_path, load) -> None:
    shape = shape_with(SLIDE)
    path, rotation = urdf_of(shape, tmp_path), z_up_rotation(np.array(shape.up))
    center, size = (" ".join(map(str, values)) for values in (rotation @ [0.5, 0.5, 0.9], abs(rotation @ [1.0, 1.0, 0.02])))
    wall = f'<collision><origin xyz="{center}"/><geometry><box size="{size}"/></geometry></collision></link>'
    path.write_text(path.read_text(encoding="utf-8").replace("</link>", wall, 1), encoding="utf-8")
    low, high = load(path).drive(0, (0.0, 0.5), 1.0)
    assert low == pytest.approx(0.0, abs=0.01)
    assert high == pytest.approx(0.27, abs=0.03)


def test_gravity_moves_what_is_free_to_fall(tmp_path, load) -> None:
    falling = Joint(JointKind.PRISMATIC, np.array([0.0, 1.0, 0.0]), np.zeros(3), -1.0, 1.0)
    record = load(urdf_of(shape_with(falling), tmp_path, "none")).rest(0.5)
    assert record.gravity[0] < 0.0
    assert record.values[0] < -0.05
    assert 0.0 < record.fastest < 1.0


def test_a_missing_mesh_is_a_load_error(tmp_path, load) -> None:
    path = urdf_of(shape_with(HINGE), tmp_path, "mesh")
    for mesh in (path.parent / "meshes").iterdir():
        mesh.unlink()
    with pytest.raises(LoadError):
        load(path)


def test_a_screw_agrees(tmp_path, load) -> None:
    screw = Joint(JointKind.SCREW, np.array([0.0, 0.0, 1.0]), np.array([0.5, 0.5, 0.0]), 0.0, 0.3)
    shape = shape_with(screw)
    kinematics = expected_kinematics(shape.mobility, np.array(shape.up), 1.0)
    check = check_object("", load(urdf_of(shape, tmp_path, "none")), kinematics, shape.diagonal)
    assert check.agrees, check.problems


@pytest.mark.parametrize("friction", [0.0, None], ids=["without friction", "with friction"])
def test_friction_holds_a_light_button(tmp_path, load, friction: float | None) -> None:
    press = Joint(JointKind.PRISMATIC, np.array([0.0, 1.0, 0.0]), np.zeros(3), -0.004, 0.004)
    boxes = [BASE, ((0.4, 1.01, 0.2), (0.5, 1.03, 0.3))]
    shape = shape_of_boxes(boxes, [Body(0, "case", (1,)), Body(1, "button", (2,), 0, press)])
    physics = Physics(friction=friction)
    paths = export(shape, shape.mobility, tmp_path / "out", ["urdf", "mjcf"], ExportOptions(collision="none", physics=physics))
    for path in paths.values() if "Mujoco" in load.__name__ else [paths["urdf"]]:
        simulator = load(path)
        sunk = -simulator.rest(0.5).values[0]
        assert sunk > 0.003 if friction == 0.0 else abs(sunk) < 1e-4, path.name
        low, high = simulator.drive(0, (-0.004, 0.004), 1.0)
        assert low < -0.0039 and high > 0.0039, path.name


def test_friction_holds_buttons_on_a_part_that_falls(tmp_path, load) -> None:
    tilt = Joint(JointKind.REVOLUTE, np.array([1.0, 0.0, 0.0]), np.array([0.5, 1.2, 0.2]), -3.0, 3.0)
    press = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), -0.004, 0.004)
    buttons = [((x, y, 0.3), (x + 0.1, y + 0.1, 0.32)) for x in (0.1, 0.4, 0.7) for y in (1.1, 1.3)]
    bodies = [Body(0, "stand", (1,)), Body(1, "head", (2,), 0, tilt)]
    bodies += [Body(index, "button", (index + 1,), 1, press) for index in range(2, 2 + len(buttons))]
    shape = shape_of_boxes([BASE, ((0.0, 1.05, 0.2), (1.0, 1.5, 0.29)), *buttons], bodies)
    for path in export(shape, shape.mobility, tmp_path / "out", ["urdf", "mjcf"], ExportOptions(collision="none")).values():
        if path.suffix == ".urdf" or "Mujoco" in load.__name__:
            simulator = load(path)
            values = dict(zip([joint.name for joint in simulator.joints], simulator.rest(1.0).values, strict=True))
            assert abs(values.pop("head_joint")) > 0.1
            assert max(map(abs, values.values())) < 2e-4, path.name
            low, high = simulator.drive(3, (-0.004, 0.004), 1.0)
            assert low < -0.0038 and high > 0.0038, path.name
