"""Shaded picture of meshes, from the depths and parts that the Rust core renders."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.view.picture_camera import DISTANCE, Camera

F64 = NDArray[np.float64]

SMOOTHING = 2
"""Samples along each side of a pixel."""
LIGHT = np.array([0.40, -0.60, -0.70]) / np.linalg.norm([0.40, -0.60, -0.70])
"""Direction to the light in the camera's frame: over the viewer's right shoulder, so that the front is the brightest side."""
AMBIENT = 0.45
OUTLINE = 0.45
"""Share of the colour that lines between parts keep."""
NEAR, FAR = 0.5 * DISTANCE, 2.0 * DISTANCE
"""Range of depths, in radii of the object."""


def shade(camera: Camera, meshes: Sequence[Mesh], colors: F64) -> NDArray[np.uint8]:
    """Draw meshes, lit on both sides, with dark lines between parts.

    Args:
        camera: The camera.
        meshes: One mesh for each part.
        colors: Colour [P, 3] of each part, in 0..1.

    Returns:
        RGBA picture [size, size, 4], transparent where nothing is seen.
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


def _normals(depths: NDArray[np.float64], focal: float, center: F64) -> F64:
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
