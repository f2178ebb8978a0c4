"""Picture of an object with its moving part coloured and joint axes over it (as in the paper's figures 3, 4 and 6)."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Mesh, join
from kinmo.core.vector import Vector
from kinmo.view.picture_camera import Camera, front_left
from kinmo.view.picture_raster import shade

SIZE = 300
"""Width and height of a picture in pixels."""
MOVING = (0.36, 0.58, 0.86)
STILL = (0.80, 0.80, 0.78)
OVERHANG = 0.08
"""Length of an axis beyond the moving part, in diagonals."""


@dataclass(frozen=True, eq=False)
class Axis:
    """A joint to draw; `role` names its style in the page: "truth", "refined" or "network"."""

    joint: Joint
    role: str


def object_picture(
    meshes: tuple[Mesh, ...], moving: frozenset[int], axes: tuple[Axis, ...], up: Vector, label: str, size: int = SIZE
) -> str:
    """Draw an object from the front left, with its joint axes as arrows.

    A slider's axis has no position and is drawn through the middle of the moving part.

    Args:
        meshes: Meshes of the object's leaves.
        moving: Positions in `meshes` of the leaves to colour.
        axes: Joints to draw, in the frame of the meshes.
        up: Unit vector [3] that points up in that frame.
        label: Text for readers who do not see pictures.
        size: Width and height in pixels.

    Returns:
        An SVG.
    """
    camera = front_left(join(*meshes).corners, up, size)
    colors = np.array([MOVING if part in moving else STILL for part in range(len(meshes))])
    image = _png(shade(camera, meshes, colors))
    around = join(*(meshes[part] for part in sorted(moving) or range(len(meshes)))).corners
    arrows = "".join(_arrow(camera, axis, around, 2.0 * camera.radius * OVERHANG) for axis in axes)
    return (
        f'<svg class="object" viewBox="0 0 {size} {size}" role="img" aria-label="{escape(label, quote=True)}">'
        f'<image href="data:image/png;base64,{image}" width="{size}" height="{size}"/>{arrows}</svg>'
    )


def _arrow(camera: Camera, axis: Axis, around: NDArray[np.float64], overhang: float) -> str:
    """An arrow along the axis over the extent of the points `around` [N, 3]."""
    joint = axis.joint
    middle = 0.5 * (around.min(axis=0) + around.max(axis=0))
    through = middle if joint.kind is JointKind.PRISMATIC else joint.pivot
    along = (around - through) @ joint.direction
    ends = through + np.array([along.min() - overhang, along.max() + overhang])[:, None] * joint.direction
    (x0, y0), (x1, y1) = camera.project(ends).tolist()
    heading = np.array([x1 - x0, y1 - y0])
    length = float(np.linalg.norm(heading))
    if length < 4.0:  # seen end on
        return f'<circle class="axis {axis.role}" cx="{x0:.1f}" cy="{y0:.1f}" r="5"/>'
    forth = heading / length
    side = np.array([-forth[1], forth[0]])
    tip = np.array([x1, y1])
    head = " ".join(f"{x:.1f},{y:.1f}" for x, y in (tip, tip - 11.0 * forth + 5.0 * side, tip - 11.0 * forth - 5.0 * side))
    x1, y1 = (tip - 9.0 * forth).tolist()
    line = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return (
        f'<line class="halo" {line}/><polygon class="halo" points="{head}"/>'
        f'<line class="axis {axis.role}" {line}/><polygon class="axis {axis.role}" points="{head}"/>'
    )


def _png(image: NDArray[np.uint8]) -> str:
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="png")
    return base64.b64encode(buffer.getvalue()).decode("ascii")
