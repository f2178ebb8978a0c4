"""A method that predicts no joints, for tests of what surrounds it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kinmo import _core
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import MotionType
from kinmo.core.shape_estimate import JointEstimate, ShapeEstimate
from kinmo.features.prepared_shape import PreparedShape


@dataclass(frozen=True)
class RigidMethod:
    """A method that predicts no joints."""

    name: str = "none"
    weights: str = ""
    networks: str = "none"
    config: Mapping[str, Any] = field(default_factory=dict)

    def predict(self, shape: PreparedShape, meshes: _core.Meshes) -> ShapeEstimate:
        still, bodies = JointEstimate(None, MotionType.NONE, 1.0), (Body(0, "base", shape.leaves),)
        return ShapeEstimate(shape.id, shape.category, Mobility(bodies), ((still,),), (still,), self.name)


def source_of(folder: Path) -> str:
    """Source that a prediction states."""
    return str(json.loads((folder / "joints.json").read_text(encoding="utf-8"))["shape"]["source"])
