"""Pictures of surfaces in soft light, with fine lines along their edges and a shadow on the ground."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from kinmo import _core
from kinmo.view.picture_raster import FAR, NEAR, Camera
from kinmo.view.surface_raster import NOTHING, Fragments, SurfaceRaster

F64 = NDArray[np.float64]

KEY_LIGHT = np.array([0.45, -0.45, -0.90]) / np.linalg.norm([0.45, -0.45, -0.90])
"""Direction to the light in the frame of the camera: over the viewer's right shoulder."""
AMBIENT, KEY, SKY = 0.55, 0.46, 0.12
"""Brightness by light from everywhere, from the light, and from above."""
LINE, CREASE_LINE = 0.45, 0.72
"""Share of the colour that lines between parts, and along creases, keep."""
CREASE_COSINE = 0.80
"""Cosine of the least angle between normals beside a line along a crease."""
STEP = 0.05
"""Least step in depth with a line, in radii of the object."""
SHADOW = 0.22
"""Opacity of the shadow."""
SHADOW_BLUR = 0.014
"""Blur of the shadow as a share of the picture."""
HIDDEN_AXIS = 0.35
"""Opacity of an axis behind a surface."""


def lit(fragments: Fragments, colors: F64, bodies: Sequence[int], *, has_creases: bool = True) -> F64:
    """RGBA samples [height, width, 4] in 0..1 of surfaces.

    Args:
        fragments: What is seen.
        colors: Red, green, blue and opacity [N, 4] of the samples where something is seen, row by row.
        bodies: Number of the body of each part. Lines run between bodies.
        has_creases: True for lines along creases, too.
    """
    seen = fragments.is_seen
    normals = fragments.normals[seen]
    light = AMBIENT + KEY * np.maximum(normals @ KEY_LIGHT, 0.0) - SKY * normals[:, 1]
    image = np.zeros((*seen.shape, 4))
    image[seen] = np.clip(colors * np.stack([light, light, light, np.ones_like(light)], axis=1), 0.0, 1.0)
    between, creases = _lines(fragments, np.append(bodies, NOTHING))
    if has_creases:
        image[creases, :3] *= CREASE_LINE
    image[between, :3] *= LINE
    return image


def with_axes(image: F64, fragments: Fragments, axes: Fragments, colors: F64) -> F64:
    """RGBA samples with axes over them, faint where a surface hides them. There is one colour [3] for each axis."""
    seen = axes.is_seen
    light = 0.75 + 0.25 * np.maximum(axes.normals[seen] @ KEY_LIGHT, 0.0)
    alpha = np.where(axes.depths[seen] <= fragments.depths[seen], 1.0, HIDDEN_AXIS)[:, None]
    under = image[seen]
    drawn = under.copy()
    drawn[:, :3] = alpha * colors[axes.parts[seen]] * light[:, None] + (1.0 - alpha) * under[:, :3]
    drawn[:, 3] = 1.0
    result = image.copy()
    result[seen] = drawn
    return np.asarray(result)


def shadow(surfaces: SurfaceRaster, poses: F64, camera: Camera, ground: float, up: F64) -> NDArray[np.uint8]:
    """RGBA picture [size, size, 4] of the soft shadow that surfaces throw on the ground.

    Args:
        surfaces: The surfaces.
        poses: Pose [P, 4, 4] of every part.
        camera: The camera.
        ground: Height of the ground along `up`.
        up: Unit vector [3] that points up.
    """
    pose = poses[surfaces.part]
    corners = np.einsum("tij,tcj->tci", pose[:, :3, :3], surfaces.corners) + pose[:, None, :3, 3]
    light = up + 0.12 * camera.rotation[0] - 0.10 * camera.rotation[2]
    heights = (corners @ up - ground) / float(light @ up)
    flat = camera.to_view((corners - heights[..., None] * light).reshape(-1, 3))
    image = np.zeros((camera.size, camera.size, 4), np.uint8)
    if len(flat):
        scene = _core.Meshes([flat], [np.arange(len(flat), dtype=np.uint32).reshape(-1, 3)])
        size, focal = (camera.size, camera.size), np.full(2, camera.focal)
        _, (parts,) = _core.render(scene, np.eye(4)[None, None], size, focal, camera.center, near=0.25 * NEAR, far=2.0 * FAR)
        image[..., 3] = np.round(255.0 * SHADOW * gaussian_filter((parts >= 0).astype(float), SHADOW_BLUR * camera.size))
    return image


def pixels(samples: F64, per_pixel: int) -> NDArray[np.uint8]:
    """RGBA picture [size, size, 4] of samples, averaged over each pixel."""
    height, width, _ = samples.shape
    blocks = samples.reshape(height // per_pixel, per_pixel, width // per_pixel, per_pixel, 4)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    color = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.maximum(alpha, 1e-9)
    return np.round(255.0 * np.concatenate([color, alpha], axis=-1)).astype(np.uint8)


def _lines(fragments: Fragments, bodies: NDArray[np.int64]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Samples [height, width] on lines between bodies or steps in depth, and on lines along creases.

    `bodies` has the body of each part, and `NOTHING` at its end.
    """
    seen, normals, owners = fragments.is_seen, fragments.normals, bodies[fragments.parts]
    depths = np.where(seen, fragments.depths, 2.0 * FAR)
    between, creases = np.zeros(seen.shape, bool), np.zeros(seen.shape, bool)
    for axis in (0, 1):
        here = (slice(None),) * axis + (slice(1, None),)
        there = (slice(None),) * axis + (slice(None, -1),)
        is_border = (owners[here] != owners[there]) | (np.abs(depths[here] - depths[there]) > STEP)
        between[here] |= is_border
        between[there] |= is_border
        creases[here] |= np.einsum("...i,...i->...", normals[here], normals[there]) < CREASE_COSINE
    return between & seen, maximum_filter(creases, 2) & seen & ~between
