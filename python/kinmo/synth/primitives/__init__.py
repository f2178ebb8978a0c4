"""Building blocks of parts: functions that return a `Mesh` with 12 to a few thousand triangles."""

from kinmo.core.shape import join
from kinmo.synth.primitives.basic_solids import (
    box,
    box_between,
    cylinder,
    dome,
    ellipsoid,
    extrude,
    open_box,
    rounded_box,
    rounded_outline,
    sheet,
    tube,
)
from kinmo.synth.primitives.swept_surfaces import arc_path, grid_faces, lathe, rounded_path, sweep, sweep_outline, torus
from kinmo.synth.primitives.transforms import (
    ORIGIN,
    Point,
    X,
    Y,
    Z,
    along,
    facing,
    inside_out,
    mirror,
    move,
    rotation,
    rotation_about,
    scale,
    transform,
    turn,
)

__all__ = [
    "ORIGIN", "Point", "X", "Y", "Z", "along", "arc_path", "box", "box_between", "cylinder", "dome", "ellipsoid", "extrude",
    "facing", "grid_faces", "inside_out", "join", "lathe", "mirror", "move", "open_box", "rotation", "rotation_about",
    "rounded_box", "rounded_outline", "rounded_path", "scale", "sheet", "sweep", "sweep_outline", "torus", "transform",
    "tube", "turn",
]  # fmt: skip
