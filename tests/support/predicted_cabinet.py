"""A cabinet as .glb, and a method without networks that predicts its joints with typical mistakes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape

PIECES = {
    "frame": ((0.0, 0.5, -0.01), (0.8, 1.0, 0.48)),
    "door": ((0.0, 0.7, 0.245), (0.78, 0.56, 0.02)),
    "knob": ((0.33, 0.7, 0.27), (0.04, 0.04, 0.03)),
    "front": ((0.0, 0.2, 0.245), (0.78, 0.36, 0.02)),
    "box": ((0.0, 0.2, 0.0), (0.7, 0.3, 0.44)),
}
"""Centre and extents of each part. The door turns about its left edge, x = -0.39."""
CORRECTIONS = """
[bodies.door]
alternative = 2
flip = true
range = [0, 110]
parts = ["door", "knob"]

[bodies.front]
name = "drawer"
parts = ["front", "box"]
range = [0, 0.3]
"""
"""An overrides.toml that corrects the mistakes of `CabinetMethod`."""
UP, OUT = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
LEFT, RIGHT = np.array([-0.39, 0.7, 0.245]), np.array([0.39, 0.7, 0.245])


def write_cabinet_glb(path: Path, names: Sequence[str] = tuple(PIECES)) -> Path:
    """Write the cabinet as a flat .glb. `names` are the names of its nodes, in the order of `PIECES`."""
    scene = trimesh.Scene()
    for name, (center, extents) in zip(names, PIECES.values(), strict=True):
        box = trimesh.creation.box(extents, trimesh.transformations.translation_matrix(center))
        scene.add_geometry(box, node_name=name, geom_name=name)
    path.parent.mkdir(parents=True, exist_ok=True)
    scene.export(path)
    return path


def hinge(pivot: np.ndarray) -> Joint:
    return Joint(JointKind.REVOLUTE, UP, pivot, 0.0, np.pi / 2)


def slider() -> Joint:
    return Joint(JointKind.PRISMATIC, OUT, np.zeros(3), 0.0, 0.2)


@dataclass(frozen=True)
class CabinetMethod:
    """Predicts the door at the wrong side, a hinge for the knob, and a drawer without its box.

    Bodies: base (frame, box), door (best joint at the right, then at the left, then a slider, then fixed), knob, front.
    """

    name: str = "cabinet"
    weights: str = "0"
    networks: str = "none"
    config: Mapping[str, Any] = field(default_factory=dict)

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        frame, box, door, front, knob = shape.leaves  # readers of scenes sort parts by area
        names = shape.part_names
        bodies = (
            Body(0, "base", (frame, box)),
            Body(1, names[door], (door,), 0, hinge(RIGHT)),
            Body(2, names[knob], (knob,), 1, hinge(LEFT)),
            Body(3, names[front], (front,), 0, slider()),
        )
        still = JointEstimate(None, MotionType.FIXED, 1.0)
        of_door = (
            JointEstimate(hinge(RIGHT), MotionType.R_V_S, 0.4, {"sweep": 0.5}, "box edge"),
            JointEstimate(hinge(LEFT), MotionType.R_V_S, 0.3, {"sweep": 1.0}, "box edge"),
            JointEstimate(slider(), MotionType.P_H, 0.2),
            JointEstimate(None, MotionType.FIXED, 0.1),
        )
        of_knob, of_front = JointEstimate(hinge(LEFT), MotionType.R_V_S, 0.6), JointEstimate(slider(), MotionType.P_H, 0.9)
        estimates = ((still,), of_door, (of_knob,), (of_front,))
        return ShapeEstimate(
            shape.id, shape.category, Mobility(bodies), estimates, tuple(ranked[0] for ranked in estimates), self.name
        )
