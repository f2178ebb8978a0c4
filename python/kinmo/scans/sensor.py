"""What a real depth camera adds to a rendered picture: noise, holes, and what stands behind the object."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from kinmo.config import SensorConfig
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

    `floors` [F, 4] are the planes below the object in the camera's frame: n . x = d for (n, d). What stands there is the part
    `NOTHING`, as what is not seen is; that one has no depth.
    """
    if sensor == SensorConfig():
        return images
    depths, parts = images.depths.copy(), images.parts.copy()
    for depth, part, floor in zip(depths, parts, floors, strict=True):
        if sensor.floor:
            _put_floor(depth, part, camera, floor)
        lost = np.zeros(depth.shape, bool)
        if sensor.steep:
            lost |= _facing(depth, camera) < STEEP
        if sensor.holes > 0.0:
            field = gaussian_filter(rng.normal(size=depth.shape), HOLE_PATCH)
            lost |= field > np.quantile(field, 1.0 - sensor.holes)
        if sensor.crop > 0.0:
            lost |= _beyond_crop(part, sensor.crop * rng.uniform(), rng)
        if sensor.noise > 0.0:
            field = gaussian_filter(rng.normal(size=depth.shape), NOISE_PATCH)
            seen = depth > 0.0
            depth[seen] += (sensor.noise / field.std() * field * depth**2)[seen]
        depth[lost], part[lost] = 0.0, NOTHING
    return DepthImages(depths, parts)


def _put_floor(depth: F32, part: NDArray[np.int32], camera: Camera, floor: NDArray[np.float64]) -> None:
    """Fill in the plane near to the object, where it is seen and nothing is before it."""
    rays, on_object = camera.rays(), part != NOTHING
    if not on_object.any():
        return
    middle = np.median(camera.points(depth)[on_object], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        behind = floor[3] / (rays @ floor[:3])
        near = np.linalg.norm(rays * behind[..., None] - middle, axis=-1) < FLOOR_REACH
    there = near & (behind > camera.near) & (behind < camera.far) & ~on_object
    depth[there] = behind[there]


def _facing(depth: F32, camera: Camera) -> F32:
    """Cosine between every pixel's ray and the normal of what is seen there, from differences of its neighbours' places."""
    places = camera.points(depth)
    across, down = np.gradient(places, axis=1), np.gradient(places, axis=0)
    normals = np.cross(across, down)
    rays = camera.rays()
    lengths = np.linalg.norm(normals, axis=-1) * np.linalg.norm(rays, axis=-1)
    return np.asarray(np.abs(np.sum(normals * rays, axis=-1)) / np.maximum(lengths, 1e-12), np.float32)


def _beyond_crop(part: NDArray[np.int32], share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """What lies beyond a line across the picture that has `share` of the object's pixels on its far side."""
    rows, columns = np.nonzero(part != NOTHING)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    if len(rows) == 0:
        return np.zeros(part.shape, bool)
    limit = np.quantile(np.cos(angle) * columns + np.sin(angle) * rows, 1.0 - share)
    down, across = np.indices(part.shape)
    return np.asarray(np.cos(angle) * across + np.sin(angle) * down > limit)
