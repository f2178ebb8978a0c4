"""PartNet-Mobility's layout: mobility_v2.json next to the hierarchy, and meshes in textured_objs/."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from kinmo.synth.draw import Draw
from kinmo.synth.hierarchy_style import is_nested
from kinmo.synth.synth_object import Link, Motion, SynthObject
from kinmo.synth.writers.node_numbering import Numbering, number
from kinmo.synth.writers.partnet_layout import write_hierarchy, write_merged
from kinmo.synth.writers.text_files import rounded, write_json

LINK_NAME_SHARE = 0.25
"""Share of bodies with the name of their link. Others have the name of their first part."""
SCREW_FIELDS_SHARE = 0.5
"""Share of objects whose plain sliders have the fields of screws too."""


def write(obj: SynthObject, shape_id: str, folder: Path, draw: Draw) -> None:
    """Write an object with its mobility. Bodies are in random order, and their parts are leaves."""
    numbering = number(obj, draw)
    write_hierarchy(obj, shape_id, folder, numbering, "textured_objs")
    if is_nested(obj):
        write_merged(obj, folder, numbering)
    links = sorted(obj.links, key=lambda _: draw.integer(0, 1 << 30))
    screw_fields = draw.chance(SCREW_FIELDS_SHARE)
    bodies = [_body(link, index, links, numbering, draw, screw_fields) for index, link in enumerate(links)]
    write_json(folder / "mobility_v2.json", bodies)
    lines = (f"link_{body['id']} {body['joint']} {body['name']}\n" for body in bodies)
    (folder / "semantics.txt").write_text("".join(lines), encoding="utf-8")
    low, high = obj.bounds()
    write_json(folder / "bounding_box.json", {"min": rounded(low), "max": rounded(high)})


def _body(link: Link, index: int, links: list[Link], numbering: Numbering, draw: Draw, screw_fields: bool) -> dict[str, Any]:
    """One body of mobility_v2.json."""
    leaves = list(link.leaves())
    return {
        "id": index,
        "parent": -1 if link.parent is None else links.index(link.parent),
        "joint": (link.kind if link.motion is None else link.motion.type).value,
        "name": link.name if draw.chance(LINK_NAME_SHARE) else leaves[0].name,
        "parts": [{"id": numbering.ids[leaf], "name": leaf.name, "children": []} for leaf in leaves],
        "jointData": _no_joint_data(draw) if link.motion is None else _joint_data(link.motion, screw_fields),
    }


def _no_joint_data(draw: Draw) -> dict[str, Any]:
    """The jointData of a body without a joint: empty, or zeros."""
    if draw.chance(0.7):
        return {}
    zeros = {"origin": [0, 0, 0], "direction": [0, 0, 0]}
    return {"axis": zeros, "limit": {"a": 0, "b": 0, "noLimit": False}}


def _joint_data(motion: Motion, screw_fields: bool) -> dict[str, Any]:
    """The jointData of a joint: axis and limits."""
    limit: dict[str, Any] = {"a": _number(motion.a), "b": _number(motion.b), "noLimit": motion.no_limit}
    if motion.rotates or (screw_fields and not motion.is_hinge):
        turns = motion.rotation_limit
        limit |= {"rotates": motion.rotates, "noRotationLimit": motion.rotates and turns is None, "rotationLimit": turns or 0}
    return {"axis": {"origin": rounded(motion.origin), "direction": rounded(motion.direction)}, "limit": limit}


def _number(value: float) -> float:
    return float(np.round(value, 9)) + 0.0
