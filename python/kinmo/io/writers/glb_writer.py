"""GLB: the object as it looks, with one animation per joint. y is up, in metres, as glTF asks.
A y-up shape keeps its axes; the front of another one faces +z.

Every link is a node with the name of the link, below the node of its parent. At rest its transform is a translation to the
origin of its joint: a rotation or translation of the node about the joint's axis articulates the object. Below it is one node
per part, with the part's name and mesh. The field `extras` of a link's node describes its joint, in the frame of the node.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.vector import Vector
from kinmo.io.writers.glb_file import GlbFile
from kinmo.io.writers.glb_meshes import GlbMeshes
from kinmo.io.writers.texture_images import Note
from kinmo.io.writers.writer import ExportedObject
from kinmo.robot.robot import Robot, RobotJoint, RobotJointKind, RobotLink, Visual

DURATION = 4.0
"""Length of an animation in seconds."""
MAX_TURN = math.pi / 3.0
"""Largest angle between keyframes. Viewers take the shorter way between two rotations."""
MIN_STEP = 1e-6
"""Smallest motion between keyframes, relative to the whole animation."""


def write_glb(exported: ExportedObject, folder: Path) -> Path:
    """Write a GLB (see `kinmo.io.writers.writer.Writer`)."""
    path = folder / f"{exported.options.name}.glb"
    path.write_bytes(glb_bytes(exported.robot, lambda line: exported.note(f"glb: {line}")))
    return path


def glb_bytes(robot: Robot, note: Note = lambda line: None) -> bytes:
    """A robot as a binary glTF file, without its collision geometry.

    Args:
        robot: The robot.
        note: What receives a line about everything that cannot be carried.
    """
    file = GlbFile()
    meshes = GlbMeshes(file, note)
    for index in range(len(robot.links)):  # the nodes of links come first, in their order
        _add_link(file, robot, index)
    for node, link in zip(file.lists["nodes"][:], robot.links, strict=True):
        below = [_add_visual(file, meshes, visual, link, robot.gltf_rotation) for visual in link.visuals]
        node.setdefault("children", []).extend(below)
        if not node["children"]:
            del node["children"]  # glTF forbids empty lists
    for joint in robot.joints:
        _add_animation(file, robot, joint)
    return file.to_bytes(scene=0, scenes=[{"name": robot.name, "nodes": [0]}])


def _add_link(file: GlbFile, robot: Robot, index: int) -> None:
    link, joint = robot.links[index], robot.joint_of(index)
    if joint is None:
        file.add("nodes", name=link.name, translation=_vector(robot, link.origin))
        return
    extras: dict[str, Any] = {"joint": joint.name, "type": joint.kind.value, "axis": _vector(robot, joint.axis)}
    if joint.lower is not None and joint.upper is not None:
        extras |= {"lower": joint.lower, "upper": joint.upper}
    place = file.add("nodes", name=link.name, translation=_offset(robot, joint).tolist(), extras=extras)
    file.lists["nodes"][joint.parent].setdefault("children", []).append(place)


def _add_visual(file: GlbFile, meshes: GlbMeshes, visual: Visual, link: RobotLink, rotation: NDArray[np.float64]) -> int:
    """Add the node and mesh of a part. Returns the index of the node."""
    mesh = visual.mesh.moved(rotation, -rotation @ link.origin)
    return file.add("nodes", name=visual.name, mesh=meshes.add(visual.name, mesh))


def _add_animation(file: GlbFile, robot: Robot, joint: RobotJoint) -> None:
    """Add the motion of a joint from the pose of the file to its limits and back."""
    values = joint_values(joint)
    lengths = np.abs(np.diff(values))
    total = float(lengths.sum())
    times = np.concatenate([[0.0], DURATION * np.cumsum(lengths) / total]) if total > 0.0 else np.zeros(1)
    axis = robot.gltf_rotation @ joint.axis
    if joint.kind is RobotJointKind.PRISMATIC:
        path, states = "translation", _offset(robot, joint) + np.outer(values, axis)
    else:
        path, states = "rotation", Rotation.from_rotvec(np.outer(values, axis)).as_quat()
    sampler = {
        "input": file.array(times.astype(np.float32), bounds=True),
        "output": file.array(states.astype(np.float32)),
        "interpolation": "LINEAR",
    }
    channel: dict[str, Any] = {"sampler": 0, "target": {"node": joint.child, "path": path}}
    file.add("animations", name=joint.name, channels=[channel], samplers=[sampler])


def joint_values(joint: RobotJoint) -> Vector:
    """Values [K] of a joint at the keyframes of its animation: from 0 to its lower limit, to its upper limit and back to 0.

    A continuous joint makes one full turn. No two neighbours are equal, and those of a rotation differ by `MAX_TURN` at most.
    """
    corners: Sequence[float] = (0.0, 2.0 * math.pi)
    if joint.lower is not None and joint.upper is not None:
        corners = (0.0, joint.lower, joint.upper, 0.0)
    largest = math.inf if joint.kind is RobotJointKind.PRISMATIC else MAX_TURN
    least = MIN_STEP * float(np.abs(np.diff(corners)).sum())
    values = [0.0]
    for corner in corners[1:]:
        distance = abs(corner - values[-1])
        if distance > least:
            steps = math.ceil(distance / largest - 1e-9) if largest < math.inf else 1
            values += np.linspace(values[-1], corner, max(steps, 1) + 1)[1:].tolist()
    return np.array(values)


def _offset(robot: Robot, joint: RobotJoint) -> Vector:
    """Translation [3] of the node of a joint's link at rest, below the node of its parent."""
    return np.asarray(robot.gltf_rotation @ (robot.links[joint.child].origin - robot.links[joint.parent].origin)) + 0.0


def _vector(robot: Robot, vector: Vector) -> list[float]:
    """A vector [3] of the robot in the frame of glTF."""
    x, y, z = (np.asarray(robot.gltf_rotation @ vector) + 0.0).tolist()
    return [x, y, z]
