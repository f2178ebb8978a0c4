"""Surfaces of revolution (pots, bottles, knobs) and swept surfaces (handles, spouts, hoses)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.synth.primitives.transforms import Point


def grid_faces(rows: int, columns: int, *, closed: bool) -> NDArray[np.uint32]:
    """Triangles [F, 3] of a grid of vertices, row by row. `closed` joins the last column to the first."""
    row, column = np.meshgrid(np.arange(rows - 1), np.arange(columns if closed else columns - 1), indexing="ij")
    a = (row * columns + column).ravel()
    b = (row * columns + (column + 1) % columns).ravel()
    lower = np.stack([a, b, b + columns], axis=1)
    upper = np.stack([a, b + columns, a + columns], axis=1)
    return np.concatenate([lower, upper]).astype(np.uint32)


def lathe(profile: NDArray[np.float64], segments: int = 24, arc: float = 360.0, start: float = 0.0) -> Mesh:
    """Surface of revolution about the y axis.

    Args:
        profile: Points [N, 2] of (radius, y). Points of radius 0 close the surface. If the profile runs upwards on the outside,
            normals point outwards.
        segments: Number of sides.
        arc: Angle of the turn in degrees.
        start: Angle of the first side in degrees; 0 is +z and 90 is +x.
    """
    closed = arc >= 360.0
    angles = np.radians(start + np.linspace(0.0, arc, segments + (0 if closed else 1), endpoint=not closed))
    radius, height = profile[:, :1], profile[:, 1:]
    x, z = radius * np.sin(angles), radius * np.cos(angles)
    vertices = np.stack([x, np.broadcast_to(height, x.shape), z], axis=-1).reshape(-1, 3)
    return _without_slivers(Mesh(vertices, grid_faces(len(profile), len(angles), closed=closed)))


def sweep(path: NDArray[np.float64], radius: float | NDArray[np.float64], segments: int = 10, *, capped: bool = True) -> Mesh:
    """A round rod along a path [N, 3]. `radius` is one number, or one per point [N]."""
    angles = np.linspace(0.0, 2 * np.pi, segments, endpoint=False)
    outline = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return sweep_outline(path, outline, radius, capped=capped)


def sweep_outline(
    path: NDArray[np.float64], outline: NDArray[np.float64], size: float | NDArray[np.float64] = 1.0, *, capped: bool = True
) -> Mesh:
    """Outline carried along a path without twist.

    Args:
        path: Points [N, 3].
        outline: Star-shaped outline [M, 2] across the path.
        size: Scale of the outline: one number, or one per point [N].
        capped: Close both ends.
    """
    count = len(path)
    tangents = np.gradient(path, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    normal = np.cross(tangents[0], np.eye(3)[int(np.argmin(np.abs(tangents[0])))])
    sizes = np.broadcast_to(np.asarray(size, float), count)
    rings = []
    for point, tangent, factor in zip(path, tangents, sizes, strict=True):
        normal = normal - tangent * (normal @ tangent)
        normal /= np.linalg.norm(normal)
        across = np.cross(tangent, normal)
        rings.append(point + factor * (outline[:, :1] * normal + outline[:, 1:] * across))
    vertices = np.concatenate(rings)
    faces = [grid_faces(count, len(outline), closed=True)]
    if capped:
        sides = np.arange(1, len(outline) - 1)
        fan = np.stack([np.zeros_like(sides), sides, sides + 1], axis=1)
        faces += [fan[:, ::-1].astype(np.uint32), (fan + (count - 1) * len(outline)).astype(np.uint32)]
    return Mesh(vertices, np.concatenate(faces))


def arc_path(
    center: Point, radius: float, start: float, end: float, axis: str = "z", points: int = 12, *, aspect: float = 1.0
) -> NDArray[np.float64]:
    """Points [points, 3] of a circular or elliptic arc across `axis`.

    Args:
        center: Centre [3].
        radius: Radius.
        start: First angle in degrees; 0 is the axis after `axis` (z: x, x: y, y: z).
        end: Last angle in degrees.
        axis: "x", "y" or "z".
        points: Number of points.
        aspect: Stretch along the axis at 90 degrees.
    """
    angles = np.radians(np.linspace(start, end, points))
    first = {"x": 1, "y": 2, "z": 0}[axis]
    path = np.zeros((points, 3))
    path[:, first] = radius * np.cos(angles)
    path[:, (first + 1) % 3] = aspect * radius * np.sin(angles)
    path += np.asarray(center, float)
    return path


def torus(
    ring_radius: float,
    rod_radius: float,
    axis: str = "y",
    center: Point = (0.0, 0.0, 0.0),
    segments: int = 24,
    rod_segments: int = 8,
) -> Mesh:
    """A ring across `axis`."""
    path = arc_path(center, ring_radius, 0.0, 360.0, axis, segments + 1)
    return sweep(path, rod_radius, rod_segments, capped=False)


def rounded_path(points: Point | NDArray[np.float64], radius: float, corner_points: int = 5) -> NDArray[np.float64]:
    """A polyline [N, 3] whose corners are rounded by quadratic curves. They start `radius` away from each corner, at most."""
    corners = np.asarray(points, float)
    rounded = [corners[:1]]
    share = np.linspace(0.0, 1.0, corner_points)[:, None]
    for before, corner, after in zip(corners[:-2], corners[1:-1], corners[2:], strict=True):
        reach = [min(radius, 0.49 * float(np.linalg.norm(end - corner))) for end in (before, after)]
        enter, leave = (
            corner + r * (end - corner) / np.linalg.norm(end - corner) for r, end in zip(reach, (before, after), strict=True)
        )
        rounded.append((1 - share) ** 2 * enter + 2 * share * (1 - share) * corner + share**2 * leave)
    rounded.append(corners[-1:])
    return np.concatenate(rounded)


def _without_slivers(mesh: Mesh) -> Mesh:
    """The mesh without the triangles that collapse where a profile meets the axis."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    collapsed = (
        np.all(np.abs(a - b) < 1e-12, axis=1) | np.all(np.abs(b - c) < 1e-12, axis=1) | np.all(np.abs(c - a) < 1e-12, axis=1)
    )
    return Mesh(mesh.vertices, mesh.faces[~collapsed])
