"""Shaded triangles as an RGBA picture, by a depth buffer in NumPy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from kinmo.view.picture_camera import Camera

F64 = NDArray[np.float64]
U8 = NDArray[np.uint8]

SAMPLES_AT_ONCE = 1_000_000
"""Pairs of triangle and pixel tested together; bounds the memory."""
LIGHT = np.array([0.40, 0.60, 0.70])
"""Direction to the light in the camera's frame: over the viewer's right shoulder, so that the front is the brightest side."""
AMBIENT = 0.45
OUTLINE = 0.45
"""How dark the lines between parts are, as a share of the colour."""


def visible_faces(camera: Camera, triangles: F64) -> NDArray[np.int64]:
    """Index [size, size] of the triangle of `triangles` [F, 3, 3] seen in every pixel, -1 for none."""
    pixels, depths = camera.project(triangles)
    size = camera.size
    nearest = np.full(size * size, -np.inf)
    face_of = np.full(size * size, -1, np.int64)
    for faces, where, depth in _covered(pixels, depths, size):
        np.maximum.at(nearest, where, depth)
        wins = nearest[where] == depth
        face_of[where[wins]] = faces[wins]
    return face_of.reshape(size, size)


def _covered(pixels: F64, depths: F64, size: int) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], F64]]:
    """Triangle, pixel (row-major) and depth of every pixel centre inside a projected triangle, a bounded number at once."""
    low = np.clip(np.ceil(pixels.min(axis=1) - 0.5), 0, size).astype(np.int64)
    high = np.clip(np.floor(pixels.max(axis=1) - 0.5) + 1, 0, size).astype(np.int64)
    extent = np.maximum(high - low, 0)
    counts = extent[:, 0] * extent[:, 1]
    a, b, c = pixels[:, 0], pixels[:, 1], pixels[:, 2]
    double_area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    drawn = np.flatnonzero((counts > 0) & (np.abs(double_area) > 1e-12))
    ends = np.cumsum(counts[drawn])
    start = 0
    while start < len(drawn):
        done = ends[start - 1] if start else 0
        stop = max(int(np.searchsorted(ends, done + SAMPLES_AT_ONCE, side="right")), start + 1)
        some = drawn[start:stop]
        face = np.repeat(some, counts[some])
        local = np.arange(len(face)) - np.repeat(ends[start:stop] - counts[some] - done, counts[some])
        x = low[face, 0] + local % extent[face, 0]
        y = low[face, 1] + local // extent[face, 0]
        center = np.stack([x + 0.5, y + 0.5], axis=-1)
        weights = np.stack(
            [_cross(pixels[face, i] - center, pixels[face, (i + 1) % 3] - center) / double_area[face] for i in (1, 2, 0)]
        )
        inside = np.all(weights >= 0.0, axis=0)
        depth = np.einsum("if,fi->f", weights[:, inside], depths[face[inside]])
        yield face[inside], (y * size + x)[inside], depth
        start = stop


def _cross(first: F64, second: F64) -> F64:
    result: F64 = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return result


def shade(camera: Camera, triangles: F64, colors: F64, parts: NDArray[np.int64], smoothing: int = 2) -> U8:
    """Picture [size, size, 4] of `triangles` [F, 3, 3] with `colors` [F, 3] in 0..1, transparent where nothing is.

    Both sides of a triangle are lit. A dark line runs where the number in `parts` [F] changes from pixel to pixel.
    A pixel is the mean of `smoothing` times `smoothing` samples.
    """
    fine = Camera(camera.rows, camera.center, camera.scale * smoothing, camera.size * smoothing)
    faces = visible_faces(fine, triangles)
    seen = faces >= 0
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals = sides / np.maximum(np.linalg.norm(sides, axis=1, keepdims=True), np.finfo(float).tiny)
    light = LIGHT / np.linalg.norm(LIGHT) @ camera.rows
    brightness = AMBIENT + (1.0 - AMBIENT) * np.abs(normals @ light)
    image = np.zeros((*faces.shape, 4))
    image[seen, :3] = (colors * brightness[:, None])[faces[seen]]
    image[seen, 3] = 1.0
    part_seen = np.where(seen, parts[faces], -1)
    border = np.zeros_like(seen)
    border[:, 1:] |= part_seen[:, 1:] != part_seen[:, :-1]
    border[1:] |= part_seen[1:] != part_seen[:-1]
    image[border & seen, :3] *= OUTLINE
    blocks = image.reshape(camera.size, smoothing, camera.size, smoothing, 4)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    color = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    picture: U8 = np.round(255.0 * np.concatenate([color, alpha], axis=-1)).astype(np.uint8)
    return picture
