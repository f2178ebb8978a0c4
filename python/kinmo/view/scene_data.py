"""Scenes as plain data, which `object_viewer.js` shows."""

from __future__ import annotations

import base64
import gzip
import json
from typing import Any

from kinmo.core.joint import KIND_WORDS
from kinmo.core.wording import clean_text
from kinmo.view.object_scene import ObjectScene, SceneOption


def scene_data(scene: ObjectScene) -> dict[str, Any]:
    """A scene as data that JSON can hold. Its geometry is a compressed GLB."""
    nodes = {visual.leaf: visual.name for link in scene.robot.links for visual in link.visuals}
    parts = scene.shape.parts
    return {
        "name": clean_text(scene.name),
        "facts": scene.facts,
        "notes": [clean_text(note) for note in scene.notes],
        "unit": scene.unit,
        "front": scene.front.tolist(),
        "bodies": [
            {
                "name": body.name,
                "key": body.key,
                "parent": body.parent,
                "color": list(body.color),
                "parts": [{"name": clean_text(parts[i].name) or nodes[i], "node": nodes[i]} for i in body.leaves],
                "options": [_option_data(option) for option in body.options],
                "chosen": body.chosen,
            }
            for body in scene.bodies
        ],
        "glb": base64.b64encode(gzip.compress(scene.glb(), mtime=0)).decode("ascii"),
    }


def scene_json(scene: ObjectScene) -> str:
    """A scene as JSON that may stand in a script element of a page."""
    return json.dumps(scene_data(scene), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _option_data(option: SceneOption) -> dict[str, Any]:
    joint = option.joint
    facts = {"label": option.label, "probability": option.probability, "rank": option.rank, "byHand": option.is_by_hand}
    if joint is None:
        return {**facts, "kind": None}
    return {
        **facts,
        "kind": KIND_WORDS[joint.kind],
        "axis": joint.direction.tolist(),
        "pivot": joint.pivot.tolist(),
        "lower": joint.lower,
        "upper": joint.upper,
    }
