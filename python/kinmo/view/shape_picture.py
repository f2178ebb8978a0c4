"""Picture of an object with its moving part coloured and joint axes over it (as in the paper's figures 3, 4 and 6)."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Mesh, join
from kinmo.core.vector import Vector
from kinmo.dataset.store import PreparedStore
from kinmo.pipeline.evaluation.example_predictions import Example
from kinmo.view.example_shape import example_shape
from kinmo.view.picture_raster import Camera, front_left, shade

SIZE = 300  # width and height of a picture in pixels
MOVING = (0.36, 0.58, 0.86)
STILL = (0.80, 0.80, 0.78)
OVERHANG = 0.08  # length of an axis beyond the moving part, in diagonals


@dataclass(frozen=True, eq=False)
class Axis:
    """A joint to draw; `role` names its style in the page: "truth", "refined" or "network"."""

    joint: Joint
    role: str


def draw_example(store: PreparedStore, example: Example, roles: Mapping[str, str]) -> str:
    """SVG of a true joint and its predictions in their shape; `roles` has the name of the table's row for each style of axis.

    Raises InputError if the shape is gone, is not annotated any more, or cannot be read from its source.
    """
    shape = example_shape(store, example)
    assert shape.mobility is not None, "examples are annotated"
    bodies = [shape.mobility.bodies[index] for index in shape.mobility.descendants(example.body)]
    place = {leaf: position for position, leaf in enumerate(shape.leaves)}
    moving = frozenset(place[leaf] for body in bodies for leaf in body.leaves)
    joints = {"truth": shape.mobility.bodies[example.body].joint}
    joints |= {role: example.predictions[row].joint for role, row in roles.items()}
    axes = (Axis(joint, role) for role, joint in joints.items() if joint is not None)
    label = f"{example.category} {example.shape_id}: {example.name}"
    return object_picture(tuple(shape.meshes()), moving, tuple(axes), np.asarray(shape.up, float), label)


def object_picture(meshes: tuple[Mesh, ...], moving: frozenset[int], axes: tuple[Axis, ...], up: Vector, label: str) -> str:
    """SVG of the meshes of an object's leaves from the front left, coloured where they move, with its joint axes as arrows.

    A slider's axis has no position and is drawn through the middle of the moving part. Axes and the unit vector `up` [3] are in
    the frame of the meshes. The label is for readers who do not see pictures.
    """
    camera = front_left(join(*meshes).corners, up, SIZE)
    colors = np.array([MOVING if part in moving else STILL for part in range(len(meshes))])
    image = _png(shade(camera, meshes, colors))
    around = join(*(meshes[part] for part in sorted(moving) or range(len(meshes)))).corners
    arrows = "".join(_arrow(camera, axis, around, 2.0 * camera.radius * OVERHANG) for axis in axes)
    return (
        f'<svg class="object" viewBox="0 0 {SIZE} {SIZE}" role="img" aria-label="{escape(label, quote=True)}">'
        f'<image href="data:image/png;base64,{image}" width="{SIZE}" height="{SIZE}"/>{arrows}</svg>'
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
