"""PartNet-Mobility's own layout: mobility_v2.json, result.json, meta.json, semantics.txt, textured_objs/.

Limits of hinges are in degrees, as that layout has them; everything else is in the frame and the lengths of the shape.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from kinmo.export.folders import whole_folder
from kinmo.export.obj import write_obj
from kinmo.joint import Joint, JointKind
from kinmo.mobility import Body, Mobility
from kinmo.shape import Shape

WORDS = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slider", JointKind.SCREW: "slider"}
"""What the layout calls a joint; a screw is a slider whose limit says that it rotates."""


def write_partnet_mobility(shape: Shape, mobility: Mobility, folder: Path) -> Path:
    """Write `shape` with `mobility` (over its leaves, in its frame and lengths) to `folder`, replaced as a whole; returns it.

    Reading it again gives the same bodies and joints. Every leaf keeps its mesh, its id and its name.
    """
    with whole_folder(folder) as draft:
        (draft / "textured_objs").mkdir()
        for leaf, mesh in zip(shape.leaves, shape.meshes(), strict=True):
            write_obj(draft / "textured_objs" / f"{_mesh_name(shape, leaf)}.obj", mesh)
        _write_json(draft / "result.json", [_node(shape, 0)])
        bodies = [_body(shape, mobility, index) for index in range(len(mobility.bodies))]
        _write_json(draft / "mobility_v2.json", bodies)
        _write_json(draft / "meta.json", {"model_cat": shape.category, "anno_id": shape.partnet_id or ""})
        lines = (f"link_{body['id']} {body['joint']} {body['name']}\n" for body in bodies)
        (draft / "semantics.txt").write_text("".join(lines), encoding="utf-8")
    return folder


def _write_json(path: Path, content: Any) -> None:
    path.write_text(json.dumps(content, ensure_ascii=False), encoding="utf-8")


def _mesh_name(shape: Shape, leaf: int) -> str:
    return f"part_{shape.parts[leaf].id}"


def _node(shape: Shape, index: int) -> dict[str, Any]:
    part = shape.parts[index]
    node: dict[str, Any] = {"id": part.id, "name": part.name, "text": part.name}
    if part.is_leaf:
        return node | {"objs": [_mesh_name(shape, index)]}
    return node | {"children": [_node(shape, child) for child in part.children]}


def _body(shape: Shape, mobility: Mobility, index: int) -> dict[str, Any]:
    body = mobility.bodies[index]
    return {
        "id": index,
        "parent": -1 if body.parent is None else body.parent,
        "joint": _word(mobility, body),
        "name": body.name,
        "parts": [{"id": shape.parts[leaf].id, "name": shape.parts[leaf].name, "children": []} for leaf in body.leaves],
        "jointData": {} if body.joint is None else _joint_data(body.joint),
    }


def _word(mobility: Mobility, body: Body) -> str:
    if body.joint is not None:
        return WORDS[body.joint.kind]
    if body.leaves and mobility.junk.issuperset(body.leaves):
        return "junk"
    return "heavy" if body.parent is None else "static"


def _joint_data(joint: Joint) -> dict[str, Any]:
    unit = math.degrees(1.0) if joint.kind is JointKind.REVOLUTE else 1.0
    limited = joint.lower is not None and joint.upper is not None and joint.lower < joint.upper
    limit: dict[str, Any] = {
        "a": joint.lower * unit if limited and joint.lower is not None else 0,
        "b": joint.upper * unit if limited and joint.upper is not None else 0,
        "noLimit": not limited,
    }
    if joint.kind is JointKind.SCREW:
        limit |= {"rotates": True, "noRotationLimit": True, "rotationLimit": 0}
    return {"axis": {"origin": joint.pivot.tolist(), "direction": joint.direction.tolist()}, "limit": limit}
