"""Building blocks of procedural parts: functions that return a `Mesh`, from twelve triangles to some thousands."""

from kinmo.core.shape import join
from kinmo.synth.primitives.place import X, Y, Z, along, inside_out, mirror, move, scale, transform, turn
from kinmo.synth.primitives.solids import (
    box,
    box_between,
    cylinder,
    dome,
    ellipsoid,
    extrude,
    rounded_box,
    rounded_outline,
    sheet,
    tube,
)
from kinmo.synth.primitives.turned import arc_path, lathe, rounded_path, sweep, sweep_outline, torus

__all__ = [
    "X",
    "Y",
    "Z",
    "along",
    "arc_path",
    "box",
    "box_between",
    "cylinder",
    "dome",
    "ellipsoid",
    "extrude",
    "inside_out",
    "join",
    "lathe",
    "mirror",
    "move",
    "rounded_box",
    "rounded_outline",
    "rounded_path",
    "scale",
    "sheet",
    "sweep",
    "sweep_outline",
    "torus",
    "transform",
    "tube",
    "turn",
]
