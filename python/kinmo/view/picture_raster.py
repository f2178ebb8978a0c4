"""Shaded picture of meshes: a camera in front of the object, and the depths and parts that the Rust core renders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector

F64 = NDArray[np.float64]

FRONT, SIDE, ABOVE = 1.0, -0.55, 0.5
"""Direction to the viewer along front, side and up: in front of the object, to its left, a little above."""
DISTANCE = 6.0  # distance of the viewer from the middle of the object, in radii of the object
MARGIN = 0.1  # share of the picture that is left free at each side
MIN_EXTENT = 1e-9  # least extent of what is seen, over its distance: a single point is not enlarged further
SMOOTHING = 2  # samples along each side of a pixel
LIGHT = np.array([0.40, -0.60, -0.70]) / np.linalg.norm([0.40, -0.60, -0.70])
"""Direction to the light in the camera's frame: over the viewer's right shoulder, so that the front is the brightest side."""
AMBIENT = 0.45
OUTLINE = 0.45  # share of the colour that lines between parts keep
NEAR, FAR = 0.5 * DISTANCE, 2.0 * DISTANCE  # range of depths, in radii of the object


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera with square pictures. Lengths in its frame are in radii of the object."""

    rotation: F64  # unit vectors [3, 3] to the right, down and forward, as rows
    middle: Vector  # point [3] that the camera looks at
    radius: float  # radius of the object
    focal: float  # focal length in pixels
    center: F64  # principal point [2] in pixels, from the upper left corner
    size: int  # width and height of the picture in pixels

    def to_view(self, points: F64) -> F64:
        """Points [..., 3] in the frame of the camera: x to the right, y down, z forward."""
        return np.asarray((points - self.middle) @ self.rotation.T / self.radius + [0.0, 0.0, DISTANCE])

    def project(self, points: F64) -> F64:
        """Pixels [..., 2] of points [..., 3]."""
        seen = self.to_view(points)
        return self.focal * seen[..., :2] / seen[..., 2:] + self.center


def front_left(points: F64, up: Vector, size: int, front: Vector | None = None, side: float = SIDE) -> Camera:
    """Camera with pictures of `size` pixels that sees all points [N, 3] from the front left.

    The front of an object is `front` [3]. By default it is +z where `up` [3], a unit vector, is y (PartNet's convention), and
    -y where it is z. The viewer is aside by `side` for one unit along the front.
    """
    if front is None:
        front = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.9 else np.array([0.0, -1.0, 0.0])
    front = front - up * (front @ up)
    toward = FRONT * front / np.linalg.norm(front) + side * np.cross(up, front) + ABOVE * up
    toward /= np.linalg.norm(toward)
    right = np.cross(up, toward)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(right, toward), -toward])
    low, high = points.min(axis=0), points.max(axis=0)
    radius = max(0.5 * float(np.linalg.norm(high - low)), np.finfo(float).tiny)
    camera = Camera(rotation, 0.5 * (low + high), radius, 1.0, np.zeros(2), size)
    seen = camera.project(points)
    first, last = seen.min(axis=0), seen.max(axis=0)
    focal = (1.0 - 2.0 * MARGIN) * size / max(float(np.max(last - first)), MIN_EXTENT)
    return Camera(rotation, camera.middle, radius, focal, 0.5 * size - focal * 0.5 * (first + last), size)


def shade(camera: Camera, meshes: Sequence[Mesh], colors: F64) -> NDArray[np.uint8]:
    """RGBA picture [size, size, 4] of meshes, lit on both sides, with dark lines between parts.

    Each part has a mesh and a colour [3] in 0..1. The picture is transparent where nothing is seen.
    """
    size, focal, center = SMOOTHING * camera.size, SMOOTHING * camera.focal, SMOOTHING * camera.center
    seen = _core.Meshes([camera.to_view(mesh.vertices) for mesh in meshes], [mesh.faces for mesh in meshes])
    poses = np.tile(np.eye(4), (1, len(meshes), 1, 1))
    (depths,), (parts,) = _core.render(seen, poses, (size, size), np.full(2, focal), center, near=NEAR, far=FAR)
    is_seen = parts >= 0
    brightness = AMBIENT + (1.0 - AMBIENT) * np.abs(_normals(np.where(is_seen, depths, FAR), focal, center) @ LIGHT)
    image = np.zeros((size, size, 4))
    image[..., :3] = colors[parts] * brightness[..., None]
    image[..., 3] = is_seen
    is_border = np.zeros_like(is_seen)
    is_border[:, 1:] |= parts[:, 1:] != parts[:, :-1]
    is_border[1:] |= parts[1:] != parts[:-1]
    image[is_border, :3] *= OUTLINE
    blocks = image.reshape(camera.size, SMOOTHING, camera.size, SMOOTHING, 4)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    color = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.round(255.0 * np.concatenate([color, alpha], axis=-1)).astype(np.uint8)


def _normals(depths: F64, focal: float, center: F64) -> F64:
    """Unit normals [size, size, 3] of the surface that is seen, of either sign, in the camera's frame."""
    rows, columns = np.indices(depths.shape) + 0.5
    points = (
        np.stack([(columns - center[0]) / focal, (rows - center[1]) / focal, np.ones_like(rows)], axis=-1) * depths[..., None]
    )
    normals = np.cross(_step(points, 0), _step(points, 1))
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), np.finfo(float).tiny))


def _step(points: F64, axis: int) -> F64:
    """Step from pixel to pixel along an axis of the picture, to the neighbour of more similar depth."""
    steps = np.diff(points, axis=axis)
    first, last = np.take(steps, [0], axis), np.take(steps, [-1], axis)
    ahead, behind = np.concatenate([steps, last], axis), np.concatenate([first, steps], axis)
    return np.where(np.abs(ahead[..., 2:]) <= np.abs(behind[..., 2:]), ahead, behind)
