"""PartNet-Mobility's own layout, so that whatever reads that reads predictions and pseudo labels too.

y-up, degrees for hinges, the file's lengths for everything else, and every joint at 0 in the pose of the meshes. Simulators
read mobility.urdf (z-up, one link for bodies fastened to each other, called after a body's number) and semantics.txt.
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

from kinmo.core.frames import Y_UP_TO_Z_UP, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.io.readers.partnet_annotation import META
from kinmo.io.writers.obj_writer import write_obj
from kinmo.io.writers.urdf_writer import robot, write_robot
from kinmo.io.writers.whole_folder import whole_folder

MESHES = "textured_objs"
LEAST_RANGE = 1e-6
"""Degrees of a hinge with limits, or diagonals of the object: less than anybody measures."""


def write_partnet_mobility(shape: Shape, mobility: Mobility, folder: Path, *, meta: Mapping[str, Any] | None = None) -> Path:
    """Write mobility_v2.json, result.json, meta.json, mobility.urdf, semantics.txt and one OBJ a leaf in textured_objs.

    Returns `folder`, which is replaced as a whole.

    `mobility` is over the leaves of `shape`, in its frame and lengths. Bodies are numbered as they stand; parts keep their ids.
    `meta` is added to meta.json.
    """
    rotation = Y_UP_TO_Z_UP.T @ z_up_rotation(np.asarray(shape.up, float))
    facts = {"model_cat": shape.category, "model_id": shape.id, "anno_id": shape.partnet_id, **(meta or {})}
    with whole_folder(folder) as draft:
        (draft / MESHES).mkdir()
        for leaf in shape.leaves:
            mesh = shape.parts[leaf].mesh
            assert mesh is not None, "a leaf carries a mesh: readers make sure of it"
            write_obj(draft / MESHES / f"{_mesh_name(leaf)}.obj", mesh.turned(rotation))
        _write(draft / META, {key: value for key, value in facts.items() if value is not None})
        _write(draft / "result.json", [_node(shape, 0)])
        bodies = [_body(shape, mobility, i, rotation) for i in range(len(mobility.bodies))]
        _write(draft / "mobility_v2.json", bodies)
        numbered = _numbered(mobility)
        files = {leaf: f"{MESHES}/{_mesh_name(leaf)}.obj" for leaf in shape.leaves}
        write_robot(robot(shape, numbered, files=files, files_rotation=Y_UP_TO_Z_UP), draft / "mobility.urdf")
        (draft / "semantics.txt").write_text("".join(_semantics(numbered, bodies)), encoding="utf-8")
    return folder


def _numbered(mobility: Mobility) -> Mobility:
    """The same bodies, called as the dataset's URDFs call links."""
    return Mobility(tuple(replace(body, name=f"link_{i}") for i, body in enumerate(mobility.bodies)), mobility.junk)


def _semantics(mobility: Mobility, entries: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """A line a link: its name, and joint and name of the body it is called after; for the base, of the first of its bodies."""
    for link in links_of(mobility):
        body = link.body if link.body is not None else next(iter(link.bodies), None)
        if body is not None:
            yield f"{link.name} {entries[body]['joint']} {'_'.join(entries[body]['name'].split()) or 'part'}\n"


def _write(path: Path, value: Any) -> None:
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
    parts = [shape.parts[leaf] for leaf in body.leaves]
    entry: dict[str, Any] = {
        "id": index,
        "parent": -1 if body.parent is None else body.parent,
        "joint": _still(body.parent, bool(body.leaves) and mobility.junk >= set(body.leaves)),
        "name": body.name,
        "parts": [{"id": part.id, "name": part.name, "children": []} for part in parts],
        "jointData": {},
    }
    if body.joint is not None:
        entry["joint"] = "hinge" if body.joint.kind is JointKind.REVOLUTE else "slider"
        entry["jointData"] = _joint_data(body.joint, rotation, shape.diagonal)
    return entry


def _still(parent: int | None, is_junk: bool) -> str:
    if is_junk:
        return "junk"
    return "heavy" if parent is None else "static"


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
    """Degrees of a hinge, else lengths; zeros without limits."""
    if joint.lower is None or joint.upper is None:
        return 0.0, 0.0
    is_hinge = joint.kind is JointKind.REVOLUTE
    unit, least = (math.degrees(1.0), LEAST_RANGE) if is_hinge else (1.0, LEAST_RANGE * diagonal)
    lower, upper = unit * (joint.lower - joint.rest), unit * (joint.upper - joint.rest)
    if upper - lower < least:  # equal limits mean none in this layout: what cannot move would come back free
        return lower - 0.5 * least, upper + 0.5 * least
    return lower, upper
