"""Faults of a real depth camera, added to rendered images: noise, holes, crops and the floor below the object."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from kinmo.config import SensorConfig
from kinmo.core.vector import Vector
from kinmo.scans.rendering.pinhole_camera import Camera
from kinmo.scans.rendering.renderers import NO_PART, DepthImages

F32 = NDArray[np.float32]

NOISE_PATCH = 1.5
"""Correlation length of depth noise, pixels."""
HOLE_PATCH = 6.0
"""Size of holes, pixels."""
FLOOR_REACH = 0.75
"""Radius of the visible floor around the middle of the visible object, diagonals. Users crop their scans about so."""
MIN_FACING_COSINE = 0.2
"""Smallest cosine between a ray and a surface normal at which a `steep` sensor still measures a depth."""


def apply_sensor(
    images: DepthImages, sensor: SensorConfig, camera: Camera, floors: NDArray[np.float64], rng: np.random.Generator
) -> DepthImages:
    """Degrade F rendered images to what a noisy sensor measures; an ideal sensor leaves them unchanged.

    Floors [F, 4] are planes below the object in the camera frame: n . x = d for (n, d), where n points up. Floor pixels get a
    depth and the part `NO_PART`; empty pixels have the depth 0 and `NO_PART`.
    """
    if sensor == SensorConfig():
        return images
    depths, parts, rays = images.depths.copy(), images.parts.copy(), camera.rays().astype(np.float32)
    for depth, part, floor in zip(depths, parts, floors, strict=True):
        if sensor.floor:
            _add_floor(depth, part, rays, camera, floor)
        window = _window(depth > 0.0)
        if window is not None:  # An object fills about a fifth of its image.
            _degrade(depth[window], part[window], rays[window], camera.focal, sensor, rng)
    return DepthImages(depths, parts)


def _window(seen: NDArray[np.bool_]) -> tuple[slice, slice] | None:
    """Rows and columns of the seen pixels with a margin of one pixel; None if the image is empty."""
    rows, columns = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    return slice(max(rows[0] - 1, 0), rows[-1] + 2), slice(max(columns[0] - 1, 0), columns[-1] + 2)


def _degrade(
    depth: F32, part: NDArray[np.int32], rays: F32, focal: Vector, sensor: SensorConfig, rng: np.random.Generator
) -> None:
    """Add the sensor's faults to one image, in place."""
    lost = np.zeros(depth.shape, bool)
    if sensor.steep:
        lost |= _facing_cosines(depth, rays, focal) < MIN_FACING_COSINE
    if sensor.holes > 0.0:
        field = _smooth_noise(depth.shape, HOLE_PATCH, rng)
        lost |= field > np.quantile(field, 1.0 - sensor.holes)
    if sensor.crop > 0.0:
        lost |= _cropped(part, sensor.crop * rng.uniform(), rng)
    if sensor.noise > 0.0:
        depth += sensor.noise * _smooth_noise(depth.shape, NOISE_PATCH, rng) * depth**2
    depth[lost], part[lost] = 0.0, NO_PART


def _smooth_noise(shape: tuple[int, ...], pixels: float, rng: np.random.Generator) -> F32:
    """Gaussian noise of variance 1, smoothed over some `pixels`."""
    smoothed = gaussian_filter(rng.standard_normal(shape, np.float32), pixels)
    return np.asarray(2.0 * np.sqrt(np.pi) * pixels * smoothed, np.float32)


def _add_floor(depth: F32, part: NDArray[np.int32], rays: F32, camera: Camera, floor: NDArray[np.float64]) -> None:
    """Add the visible floor near the object, in place; a camera below the floor sees none."""
    on_object = part != NO_PART
    if not on_object.any() or floor[3] > 0.0:
        return
    middle = np.median(rays[on_object] * depth[on_object, None], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        floor_depth = floor[3] / (rays @ floor[:3])
        near = np.linalg.norm(rays * floor_depth[..., None] - middle, axis=-1) < FLOOR_REACH
    visible = near & (floor_depth > camera.near) & (floor_depth < camera.far) & ~on_object
    depth[visible] = floor_depth[visible]


def _facing_cosines(depth: F32, rays: F32, focal: Vector) -> F32:
    """Cosines [rows, columns] of each pixel's ray and the surface normal there.

    A pixel shows the point depth * ray, and rays change by 1 / `focal` per pixel. The cross product of the point's changes
    along rows and columns, over depth / (focal * focal), is the normal below. Its product with the ray is the depth.
    """
    down, across = np.gradient(depth)
    x, y = across * np.float32(focal[0]), down * np.float32(focal[1])
    z = depth + x * rays[..., 0] + y * rays[..., 1]
    lengths = np.sqrt((x * x + y * y + z * z) * np.einsum("ijk,ijk->ij", rays, rays))
    return np.asarray(depth / np.maximum(lengths, 1e-12), np.float32)


def _cropped(part: NDArray[np.int32], share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Pixels beyond a random line that cuts off `share` of the object's pixels."""
    rows, columns = np.nonzero(part != NO_PART)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    if len(rows) == 0:
        return np.zeros(part.shape, bool)
    limit = np.quantile(np.cos(angle) * columns + np.sin(angle) * rows, 1.0 - share)
    down, across = np.indices(part.shape)
    return np.asarray(np.cos(angle) * across + np.sin(angle) * down > limit)
