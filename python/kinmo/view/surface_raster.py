"""Surfaces as a camera sees them: depth, part and smooth normal of every sample of a picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.shape import Mesh
from kinmo.view.picture_raster import DISTANCE, FAR, NEAR, Camera
from kinmo.view.smooth_surface import corner_normals

F64 = NDArray[np.float64]

BATCH = 1024
"""Triangles that are rendered together. The Rust core tells meshes apart, so that every triangle is a mesh."""
NUDGE = 2e-5
"""Share of the distance to the eye by which a part of the next rank is drawn nearer."""
NOTHING = -1
"""Part of a sample where nothing is seen."""
_FACE = np.array([[0, 1, 2]], np.uint32)


@dataclass(frozen=True, eq=False)
class Fragments:
    """The surfaces that are seen at every sample of a picture.

    Attributes:
        depths: [height, width] depths in radii of the object. Infinite where nothing is seen.
        parts: [height, width] indices of the parts. `NOTHING` where nothing is seen.
        normals: [height, width, 3] unit normals towards the viewer, in the frame of the camera.
        triangles: [height, width] indices of the triangles of all parts, one part after the other. `NOTHING` likewise.
        weights: [N, 3] share of each corner of its triangle in the samples where something is seen, row by row.
        areas: [T] areas of all triangles in the picture, in samples.
    """

    depths: F64
    parts: NDArray[np.int64]
    normals: F64
    triangles: NDArray[np.int64]
    weights: F64
    areas: F64

    @property
    def is_seen(self) -> NDArray[np.bool_]:
        """[height, width] True where something is seen."""
        return np.asarray(self.parts != NOTHING)


class SurfaceRaster:
    """Parts that can be rendered in several poses.

    Args:
        meshes: The surface of each part.
    """

    def __init__(self, meshes: Sequence[Mesh]) -> None:
        self.corners = np.concatenate([np.zeros((0, 3, 3)), *(mesh.triangles for mesh in meshes)])
        self.normals = np.concatenate([np.zeros((0, 3, 3)), *(corner_normals(mesh) for mesh in meshes)])
        self.part = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
        starts = range(0, len(self.corners), BATCH)
        groups = [np.ascontiguousarray(self.corners[start : start + BATCH]) for start in starts]
        self._batches = [_core.Meshes(list(group), [_FACE] * len(group)) for group in groups]

    def render(self, camera: Camera, poses: F64, samples: int = 1, ranks: Sequence[int] | None = None) -> Fragments:
        """See the parts.

        Args:
            camera: The camera.
            poses: Pose [P, 4, 4] of every part, as a transform from its place in the mesh.
            samples: Samples along each side of a pixel.
            ranks: Rank of every part: of surfaces in the same place, that of the highest rank is seen.
        """
        size, focal, center = samples * camera.size, samples * camera.focal, samples * camera.center
        into_view = np.eye(4)
        into_view[:3, :3] = camera.rotation / camera.radius
        into_view[:3, 3] = [0.0, 0.0, DISTANCE] - into_view[:3, :3] @ camera.middle
        moved = into_view @ poses
        if ranks is not None:  # nearer to the eye along the rays through it, which changes no outline
            moved[:, :3] *= 1.0 - NUDGE * np.asarray(ranks, float)[:, None, None]
        depths, triangles = np.full((size, size), np.inf), np.full((size, size), NOTHING, np.int64)
        for number, batch in enumerate(self._batches):
            own = moved[self.part[number * BATCH : (number + 1) * BATCH]][None]
            (near,), (found,) = _core.render(
                batch, np.ascontiguousarray(own), (size, size), np.full(2, focal), center, near=0.25 * NEAR, far=FAR
            )
            is_nearer = (found >= 0) & (near < depths)
            depths[is_nearer] = near[is_nearer]
            triangles[is_nearer] = found[is_nearer] + number * BATCH
        parts = np.where(triangles == NOTHING, NOTHING, self.part[triangles] if len(self.part) else NOTHING)
        pose = moved[self.part]
        corners = np.einsum("tij,tcj->tci", pose[:, :3, :3], self.corners) + pose[:, None, :3, 3]
        rows, columns = np.nonzero(triangles != NOTHING)
        seen = triangles[rows, columns]
        rays = np.stack([(columns + 0.5 - center[0]) / focal, (rows + 0.5 - center[1]) / focal, np.ones(len(rows))], axis=1)
        points = rays * depths[rows, columns][:, None]
        weights = _weights(seen, points, corners)
        turned = camera.radius * np.einsum("tij,tcj->tci", pose[:, :3, :3], self.normals)
        normals = np.zeros((size, size, 3))
        normals[rows, columns] = _towards_viewer(np.einsum("nc,nci->ni", weights, turned[seen]), points)
        return Fragments(depths, parts, normals, triangles, weights, _areas(corners, focal))


def _weights(triangles: NDArray[np.int64], points: F64, corners: F64) -> F64:
    """Share [N, 3] of each corner in points [N, 3] of triangles [N]. `corners` [T, 3, 3] has those of all triangles."""
    first, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    uu, uv, vv = (np.einsum("ij,ij->i", *pair) for pair in ((u, u), (u, v), (v, v)))
    determinant = np.maximum(uu * vv - uv * uv, np.finfo(float).tiny)
    offset = points - first[triangles]
    along_u, along_v = np.einsum("ij,ij->i", offset, u[triangles]), np.einsum("ij,ij->i", offset, v[triangles])
    second = np.clip((vv[triangles] * along_u - uv[triangles] * along_v) / determinant[triangles], 0.0, 1.0)
    third = np.clip((uu[triangles] * along_v - uv[triangles] * along_u) / determinant[triangles], 0.0, 1.0)
    weights = np.stack([np.maximum(1.0 - second - third, 0.0), second, third], axis=1)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))


def _towards_viewer(vectors: F64, points: F64) -> F64:
    """Vectors [N, 3] at points [N, 3] with length 1, turned around where they point away from the viewer."""
    lengths = np.maximum(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)), np.finfo(float).tiny)
    signs = np.where(np.einsum("ij,ij->i", vectors, points) > 0.0, -1.0, 1.0)
    return np.asarray(vectors * (signs / lengths)[:, None])


def _areas(corners: F64, focal: float) -> F64:
    """Areas [T] in the picture of triangles with corners [T, 3, 3]."""
    flat = focal * corners[..., :2] / np.maximum(corners[..., 2:], np.finfo(float).tiny)
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    return np.asarray(0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))
