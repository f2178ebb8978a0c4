"""Robots of shapes: names of collision geometry, and objects far from the origin."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.io.writers import ExportOptions, write_formats
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import FAR_NOTE, MAX_DISTANCE, build_robot

BOXES = [((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), ((2.0, 0.0, 0.0), (3.0, 2.0, 1.0))]


def shape_with(*names: str) -> Shape:
    """Two boxes with names, in one body."""
    return shape_of_boxes(BOXES, [Body(0, "base", (1, 2))], names=dict(enumerate(names, 1)))


def robot_of(shape: Shape, scale: float = 1.0) -> Robot:
    assert shape.mobility is not None
    return build_robot(shape, shape.mobility, scale, collision="mesh")


def collision_names(robot: Robot) -> list[str]:
    return [collision.name for link in robot.links for collision in link.collisions]


def test_collision_geometry_is_named_after_its_part() -> None:
    assert collision_names(robot_of(shape_with("door", "knob"))) == ["door_collision_0", "knob_collision_0"]


@pytest.mark.parametrize("other", ["door_collision_0", "Door/Collision 0"])
def test_no_collision_geometry_has_the_name_of_a_part(other: str) -> None:
    robot = robot_of(shape_with("door", other))
    names = [item.name.lower() for link in robot.links for item in link.geometry]
    assert len(set(names)) == len(names) == 4
    assert names[0] == "door"


@pytest.mark.parametrize("name", ["urdf", "mjcf"])
def test_no_collision_file_replaces_the_mesh_of_a_part(name: str, tmp_path: Path) -> None:
    shape = shape_with("door", "door_collision_0")
    assert shape.mobility is not None
    write_formats(shape, shape.mobility, tmp_path, [name], ExportOptions(collision="mesh"))
    files = sorted((tmp_path / "meshes").glob("*.obj"))
    assert len(files) == 4
    sizes = [round(trimesh.load_mesh(path).volume, 6) for path in files if path.stem in ("door", "door_collision_0")]
    assert sizes == [1.0, 2.0]


def moved(shape: Shape, offset: tuple[float, float, float]) -> Shape:
    parts = (
        part if part.mesh is None else replace(part, mesh=replace(part.mesh, vertices=part.mesh.vertices + offset))
        for part in shape.parts
    )
    return replace(shape, parts=tuple(parts))


def test_the_light_link_of_a_screw_is_at_its_joint() -> None:
    joint = Joint(JointKind.SCREW, np.array([0.0, 0.0, 1.0]), np.array([2.5, 1.0, 0.5]), 0.0, 0.5)
    robot = robot_of(shape_of_boxes(BOXES, [Body(0, "jar", (1,)), Body(1, "lid", (2,), 0, joint)]))
    (light,) = (link for link in robot.links if not link.visuals)
    assert np.linalg.norm(light.origin) > 2.0
    np.testing.assert_allclose(light.inertial.center, light.origin)


@pytest.mark.parametrize("scale", [1.0, 0.001])
def test_an_object_far_from_the_origin_is_noted(scale: float) -> None:
    shape = shape_with("door", "knob")
    diagonals = shape.diagonal / np.sqrt(3.0)
    near = tuple(np.full(3, 0.99 * MAX_DISTANCE * diagonals).tolist())
    far = tuple(np.full(3, 1.01 * MAX_DISTANCE * diagonals).tolist())
    assert FAR_NOTE not in robot_of(moved(shape, near), scale).notes
    assert FAR_NOTE in robot_of(moved(shape, far), scale).notes


def test_notes_about_far_objects_reach_the_export(tmp_path: Path) -> None:
    shape = moved(shape_with("door", "knob"), (5e5, 4.6e6, 100.0))
    assert shape.mobility is not None
    notes: list[str] = []
    write_formats(shape, shape.mobility, tmp_path, ["urdf", "glb"], ExportOptions(collision="none"), notes)
    assert notes == [FAR_NOTE]
