"""What a real depth camera adds to a rendered picture: noise, holes, and what stands behind the object."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from kinmo.config import SensorConfig
from kinmo.core.vector import Vector
from kinmo.scans.camera import Camera
from kinmo.scans.renderers import NOTHING, DepthImages

F32 = NDArray[np.float32]

NOISE_PATCH = 1.5
"""Pixels over which neighbouring errors hang together."""
HOLE_PATCH = 6.0
"""Pixels; the size of holes."""
FLOOR_REACH = 0.75
"""Diagonals of the object about the middle of what is seen of it, within which the floor is: scans are cut out roughly."""
STEEP = 0.2
"""Cosine of the angle between a ray and the normal of a surface below which nothing comes back."""


def sense(
    images: DepthImages, sensor: SensorConfig, camera: Camera, floors: NDArray[np.float64], rng: np.random.Generator
) -> DepthImages:
    """The pictures as the sensor takes them.

    `floors` [F, 4] are the planes below the object in the camera's frame: n . x = d for (n, d), n being up. What stands there
    is the part `NOTHING`, as what is not seen is; that one has no depth.
    """
    if sensor == SensorConfig():
        return images
    depths, parts, rays = images.depths.copy(), images.parts.copy(), camera.rays().astype(np.float32)
    for depth, part, floor in zip(depths, parts, floors, strict=True):
        if sensor.floor:
            _put_floor(depth, part, rays, camera, floor)
        window = _window(depth > 0.0)
        if window is not None:  # an object fills a fifth of its picture or so
            _spoil(depth[window], part[window], rays[window], camera.focal, sensor, rng)
    return DepthImages(depths, parts)


def _window(seen: NDArray[np.bool_]) -> tuple[slice, slice] | None:
    """Rows and columns of a picture outside which nothing is seen, with a pixel to spare on all sides; None if nothing is."""
    rows, columns = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    return slice(max(rows[0] - 1, 0), rows[-1] + 2), slice(max(columns[0] - 1, 0), columns[-1] + 2)


def _spoil(
    depth: F32, part: NDArray[np.int32], rays: F32, focal: Vector, sensor: SensorConfig, rng: np.random.Generator
) -> None:
    """Add the faults of the sensor to a picture, in place."""
    lost = np.zeros(depth.shape, bool)
    if sensor.steep:
        lost |= _facing(depth, rays, focal) < STEEP
    if sensor.holes > 0.0:
        field = _patches(depth.shape, HOLE_PATCH, rng)
        lost |= field > np.quantile(field, 1.0 - sensor.holes)
    if sensor.crop > 0.0:
        lost |= _beyond_crop(part, sensor.crop * rng.uniform(), rng)
    if sensor.noise > 0.0:
        depth += sensor.noise * _patches(depth.shape, NOISE_PATCH, rng) * depth**2
    depth[lost], part[lost] = 0.0, NOTHING


def _patches(shape: tuple[int, ...], pixels: float, rng: np.random.Generator) -> F32:
    """Random numbers of the variance 1, neighbours within so many `pixels` alike."""
    smoothed = gaussian_filter(rng.standard_normal(shape, np.float32), pixels)
    return np.asarray(2.0 * np.sqrt(np.pi) * pixels * smoothed, np.float32)


def _put_floor(depth: F32, part: NDArray[np.int32], rays: F32, camera: Camera, floor: NDArray[np.float64]) -> None:
    """Fill in the plane near to the object, where it is seen and nothing is before it; a camera below it sees none."""
    on_object = part != NOTHING
    if not on_object.any() or floor[3] > 0.0:
        return
    middle = np.median(rays[on_object] * depth[on_object, None], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        behind = floor[3] / (rays @ floor[:3])
        near = np.linalg.norm(rays * behind[..., None] - middle, axis=-1) < FLOOR_REACH
    there = near & (behind > camera.near) & (behind < camera.far) & ~on_object
    depth[there] = behind[there]


def _facing(depth: F32, rays: F32, focal: Vector) -> F32:
    """Cosine between every pixel's ray and the normal of what is seen there.

    The place of a pixel is depth * ray, and from one to the next rays change by 1 / `focal`: the cross product of what places
    change by, over depth / (focal * focal), is the normal below, whose product with the ray is the depth.
    """
    down, across = np.gradient(depth)
    x, y = across * np.float32(focal[0]), down * np.float32(focal[1])
    z = depth + x * rays[..., 0] + y * rays[..., 1]
    lengths = np.sqrt((x * x + y * y + z * z) * np.einsum("ijk,ijk->ij", rays, rays))
    return np.asarray(depth / np.maximum(lengths, 1e-12), np.float32)


def _beyond_crop(part: NDArray[np.int32], share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """What lies beyond a line across the picture that has `share` of the object's pixels on its far side."""
    rows, columns = np.nonzero(part != NOTHING)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    if len(rows) == 0:
        return np.zeros(part.shape, bool)
    limit = np.quantile(np.cos(angle) * columns + np.sin(angle) * rows, 1.0 - share)
    down, across = np.indices(part.shape)
    return np.asarray(np.cos(angle) * across + np.sin(angle) * down > limit)
