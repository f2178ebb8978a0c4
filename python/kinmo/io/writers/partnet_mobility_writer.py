"""PartNet-Mobility: the format of the dataset, so that its readers also read predictions and pseudo labels.

Shapes are y-up, in the length unit of their file, with hinge angles in degrees. Every joint has the value 0 in the pose of the
meshes. Simulators read mobility.urdf and semantics.txt. Those are z-up, with one link for bodies that are fixed to each other.
A link has the number of a body in its name.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import Y_UP_TO_Z_UP, roll_pitch_yaw, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import ShapeEstimate
from kinmo.io.readers.partnet_annotation import META_FILE, MOBILITY_FILE, PSEUDO_LABEL
from kinmo.io.writers.obj_writer import write_obj
from kinmo.io.writers.texture_images import TextureImages, materials_of
from kinmo.io.writers.urdf_writer import robot_element
from kinmo.io.writers.writer import ExportedObject
from kinmo.io.writers.xml_files import write_xml
from kinmo.robot.robot_builder import build_robot

MESHES, IMAGES = "textured_objs", "images"
"""Folders."""
MIN_RANGE = 1e-6
"""Smallest joint range that is written, in degrees (hinges) or diagonals. It is far below any measurable motion."""


def write_partnet_mobility(exported: ExportedObject, folder: Path) -> Path:
    """Write a shape as PartNet-Mobility does (see `kinmo.io.writers.writer.Writer`).

    The files are mobility_v2.json, result.json, meta.json, mobility.urdf, semantics.txt, one OBJ per leaf in textured_objs, and
    the images of their materials in images.
    Bodies are numbered in their order. Parts keep their ids. The setting `meta` is added to meta.json. Predictions that nobody
    corrected are marked there: `kinmo prepare` takes them for no annotation.
    """
    shape, result, mobility, options = exported.shape, exported.result, exported.mobility, exported.options
    rotation = Y_UP_TO_Z_UP.T @ z_up_rotation(np.asarray(shape.up, float))
    mark = {PSEUDO_LABEL: result.method} if isinstance(result, ShapeEstimate) and result.correction is None else {}
    facts = {"model_cat": shape.category or None, "model_id": shape.id, "anno_id": shape.partnet_id, **mark, **options.meta}
    (folder / MESHES).mkdir(parents=True, exist_ok=True)
    textures = TextureImages(
        folder / IMAGES, materials_of(shape.meshes()), lambda line: exported.note(f"partnet_mobility: {line}")
    )
    for leaf in shape.leaves:
        mesh = shape.leaf_mesh(leaf).rotated(rotation)
        write_obj(folder / MESHES / f"{_mesh_name(leaf)}.obj", mesh, textures, f"../{IMAGES}/")
    _write_json(folder / META_FILE, {key: value for key, value in facts.items() if value is not None})
    _write_json(folder / "result.json", [_node(shape, 0)])
    entries = [_body(shape, mobility, i, rotation) for i in range(len(mobility.bodies))]
    _write_json(folder / MOBILITY_FILE, entries)
    # the same bodies, named like the links in the URDFs of the dataset
    numbered = Mobility(tuple(replace(body, name=f"link_{i}") for i, body in enumerate(mobility.bodies)), mobility.junk)
    files = {leaf: f"{MESHES}/{_mesh_name(leaf)}.obj" for leaf in shape.leaves}
    robot = build_robot(shape, numbered, collision="mesh")
    root = robot_element(robot, lambda item: files[item.leaf], roll_pitch_yaw(Y_UP_TO_Z_UP))
    write_xml(root, folder / "mobility.urdf")
    (folder / "semantics.txt").write_text("".join(_semantics(numbered, entries)), encoding="utf-8")
    return folder


def _semantics(mobility: Mobility, entries: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """One line per link: its name, and the joint and the name of its body. The base uses its first body."""
    for link in links_of(mobility):
        body = link.body if link.body is not None else next(iter(link.bodies), None)
        if body is not None:
            yield f"{link.name} {entries[body]['joint']} {'_'.join(entries[body]['name'].split()) or 'part'}\n"


def _write_json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, allow_nan=False) + "\n", encoding="utf-8")


def _mesh_name(leaf: int) -> str:
    return f"original-{leaf}"


def _node(shape: Shape, index: int) -> dict[str, Any]:
    part = shape.parts[index]
    node: dict[str, Any] = {"text": part.name, "name": part.name, "id": part.id}
    if part.is_leaf:
        return {**node, "objs": [_mesh_name(index)]}
    return {**node, "children": [_node(shape, child) for child in part.children]}


def _body(shape: Shape, mobility: Mobility, index: int, rotation: NDArray[np.float64]) -> dict[str, Any]:
    body = mobility.bodies[index]
    return {
        "id": index,
        "parent": -1 if body.parent is None else body.parent,
        "joint": _joint_name(mobility, index),
        "name": body.name,
        "parts": [{"id": shape.parts[i].id, "name": shape.parts[i].name, "children": []} for i in body.leaves],
        "jointData": {} if body.joint is None else _joint_data(body.joint, rotation, shape.diagonal),
    }


def _joint_name(mobility: Mobility, index: int) -> str:
    """Value of the field `joint`. A screw is a slider that rotates."""
    body = mobility.bodies[index]
    if body.joint is not None:
        return "hinge" if body.joint.kind is JointKind.REVOLUTE else "slider"
    if mobility.is_junk(index):
        return "junk"
    return "heavy" if body.parent is None else "static"


def _joint_data(joint: Joint, rotation: NDArray[np.float64], diagonal: float) -> dict[str, Any]:
    lower, upper = _limits(joint, diagonal)
    return {
        "axis": {"origin": (rotation @ joint.pivot).tolist(), "direction": (rotation @ joint.direction).tolist()},
        "limit": {
            "a": lower,
            "b": upper,
            "noLimit": not joint.is_limited,
            "rotates": joint.kind is JointKind.SCREW,
            "noRotationLimit": joint.kind is JointKind.SCREW,
            "rotationLimit": 0,
        },
    }


def _limits(joint: Joint, diagonal: float) -> tuple[float, float]:
    """Limits in degrees (hinges) or lengths. Zeros without limits."""
    if joint.lower is None or joint.upper is None:
        return 0.0, 0.0
    is_hinge = joint.kind is JointKind.REVOLUTE
    unit, min_range = (math.degrees(1.0), MIN_RANGE) if is_hinge else (1.0, MIN_RANGE * diagonal)
    lower, upper = unit * (joint.lower - joint.rest), unit * (joint.upper - joint.rest)
    if upper - lower < min_range:  # in this format equal limits mean no limits
        return lower - 0.5 * min_range, upper + 0.5 * min_range
    return lower, upper
