"""Boxes, cylinders, extrusions and ellipsoids, centred at `center`. Round solids stand along `axis`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.oriented_box import CORNER_SIGNS
from kinmo.core.shape import Mesh
from kinmo.synth.primitives.swept_surfaces import grid_faces, lathe
from kinmo.synth.primitives.transforms import ORIGIN, Point, along, move

_BOX_FACES = np.array([
    [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
    [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
], np.uint32)  # fmt: skip
"""Triangles [12, 3] of a box with the corners of `CORNER_SIGNS`."""


_FRONT_RIM = ((1, 5), (5, 7), (7, 3), (3, 1))
"""Edges of a box around its front, counter-clockwise from outside."""


def box(size: Point, center: Point = ORIGIN) -> Mesh:
    """A box of 12 triangles with edge lengths `size` [3]."""
    return Mesh(CORNER_SIGNS * (0.5 * np.asarray(size, float)) + np.asarray(center, float), _BOX_FACES)


def box_between(low: Point, high: Point) -> Mesh:
    """The box with corners `low` and `high`."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    return box(high - low, 0.5 * (low + high))


def open_box(low: Point, high: Point, wall: float) -> Mesh:
    """The box between two corners, hollow and open to the front (+z), as one closed surface with walls of one thickness."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    outer = box_between(low, high)
    inner = box_between(low + wall, high - (wall, wall, 0.0))
    # The front of both boxes gives way to the rim between them: corners 1, 3, 5 and 7 are at the front.
    at_front = np.all(outer.faces % 2 == 1, axis=1)
    rim = np.array([[a, b, b + 8] for a, b in _FRONT_RIM] + [[a, b + 8, a + 8] for a, b in _FRONT_RIM], np.uint32)
    faces = [outer.faces[~at_front], inner.faces[~at_front][:, ::-1] + np.uint32(8), rim]
    return Mesh(np.concatenate([outer.vertices, inner.vertices]), np.concatenate(faces))


def sheet(size: tuple[float, float], center: Point = ORIGIN, axis: str = "y") -> Mesh:
    """A flat rectangle of two triangles across `axis`. `size` is along the next two axes (y: z, x; z: x, y; x: y, z)."""
    half = 0.5 * np.array([[-size[1], 0, -size[0]], [-size[1], 0, size[0]], [size[1], 0, size[0]], [size[1], 0, -size[0]]])
    return move(along(Mesh(half, np.array([[0, 1, 2], [0, 2, 3]], np.uint32)), axis), center)


def extrude(
    outline: NDArray[np.float64], depth: float, axis: str = "y", center: Point = ORIGIN, *, capped: bool = True
) -> Mesh:
    """A prism over a star-shaped outline.

    Args:
        outline: Outline [N, 2] in the two axes after `axis` (y: z, x; z: x, y; x: y, z). If it runs counter-clockwise, normals
            point outwards.
        depth: Length along `axis`.
        axis: "x", "y" or "z".
        center: Point [3] that the outline's origin, at half depth, is moved to.
        capped: Close both ends.
    """
    count = len(outline)
    ring = np.stack([outline[:, 1], np.zeros(count), outline[:, 0]], axis=1)
    lift = np.array([0, depth / 2, 0])
    rings = np.concatenate([ring - lift, ring + lift])
    faces = [grid_faces(2, count, closed=True)]
    if capped:
        middle = outline.mean(axis=0)
        rings = np.concatenate([rings, [[middle[1], -depth / 2, middle[0]], [middle[1], depth / 2, middle[0]]]])
        here, following = np.arange(count), np.roll(np.arange(count), -1)
        faces.append(np.stack([following, here, np.full(count, 2 * count)], axis=1))
        faces.append(np.stack([here + count, following + count, np.full(count, 2 * count + 1)], axis=1))
    return move(along(Mesh(rings, np.concatenate(faces).astype(np.uint32)), axis), center)


def rounded_outline(width: float, height: float, radius: float, corner_segments: int = 4) -> NDArray[np.float64]:
    """Outline [N, 2] of a rectangle with rounded corners, counter-clockwise."""
    radius = min(radius, 0.499 * width, 0.499 * height)
    angles = np.linspace(0, np.pi / 2, corner_segments + 1)
    corners = []
    for quarter, (sx, sy) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        turned = angles + quarter * np.pi / 2
        middle = np.array([sx * (width / 2 - radius), sy * (height / 2 - radius)])
        corners.append(middle + radius * np.stack([np.cos(turned), np.sin(turned)], axis=1))
    return np.concatenate(corners)


def rounded_box(size: Point, radius: float, axis: str = "y", center: Point = ORIGIN, corner_segments: int = 4) -> Mesh:
    """A box with edge lengths `size` [3] whose four edges along `axis` are rounded."""
    order = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}[axis]
    first, second, depth = (float(size[i]) for i in order)
    return extrude(rounded_outline(first, second, radius, corner_segments), depth, axis, center)


def cylinder(
    radius: float,
    length: float,
    axis: str = "y",
    center: Point = ORIGIN,
    segments: int = 24,
    *,
    top_radius: float | None = None,
    capped: bool = True,
) -> Mesh:
    """A cylinder, or a truncated cone.

    Args:
        radius: Radius, at the lower end of `axis`.
        length: Length along `axis`.
        axis: "x", "y" or "z".
        center: Centre [3].
        segments: Number of sides.
        top_radius: Radius at the upper end; None for `radius`.
        capped: Close both ends.
    """
    top = radius if top_radius is None else top_radius
    profile = [[radius, -length / 2], [top, length / 2]]
    if capped:
        profile = [[0.0, -length / 2], *profile, [0.0, length / 2]]
    return move(along(lathe(np.array(profile), segments), axis), center)


def tube(outer: float, inner: float, length: float, axis: str = "y", center: Point = ORIGIN, segments: int = 24) -> Mesh:
    """A hollow cylinder with a wall, open at both ends."""
    half = length / 2
    profile = np.array([[inner, half], [inner, -half], [outer, -half], [outer, half], [inner, half]])
    return move(along(lathe(profile, segments), axis), center)


def ellipsoid(radii: Point, center: Point = ORIGIN, segments: int = 16, rings: int = 8) -> Mesh:
    """An ellipsoid with half axes `radii` [3]."""
    return move(_scaled_dome(radii, segments, rings, -np.pi / 2), center)


def dome(radii: Point, center: Point = ORIGIN, axis: str = "y", segments: int = 20, rings: int = 5) -> Mesh:
    """The upper half of an ellipsoid, open below. `radii` [3] are those before it is laid along `axis`."""
    return move(along(_scaled_dome(radii, segments, rings, 0.0), axis), center)


def _scaled_dome(radii: Point, segments: int, rings: int, lowest: float) -> Mesh:
    latitude = np.linspace(lowest, np.pi / 2, rings + 1)
    unit = lathe(np.stack([np.maximum(np.cos(latitude), 0.0), np.sin(latitude)], axis=1), segments)
    return Mesh(unit.vertices * np.asarray(radii, float), unit.faces)
