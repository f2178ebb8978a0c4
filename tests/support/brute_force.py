"""Independent and slow: what the tests of `kinmo._core` compare with, and solids to try it on."""

from __future__ import annotations

import itertools

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]


def meshes_of(*solids: trimesh.Trimesh) -> _core.Meshes:
    """The solids as `Meshes`."""
    vertices = [np.ascontiguousarray(solid.vertices, float) for solid in solids]
    return _core.Meshes(vertices, [np.ascontiguousarray(solid.faces, np.uint32) for solid in solids])


def block(extents: tuple[float, ...], center: tuple[float, ...], cuts: int = 2) -> trimesh.Trimesh:
    """An axis-aligned box, its faces cut into smaller triangles."""
    solid = trimesh.creation.box(extents)
    for _ in range(cuts):
        solid = solid.subdivide()
    solid.apply_translation(center)
    return solid


def triangle_soup_distance(p: F64, q: F64) -> float:
    """Distance of two lists of triangles [N, 3, 3] by all pairs of sides, corners and crossings."""
    return min(_triangle_distance(a, b) for a, b in itertools.product(p, q))


def _triangle_distance(p: F64, q: F64) -> float:
    if any(_crosses(p[i], p[i - 1], q) or _crosses(q[i], q[i - 1], p) for i in range(3)):
        return 0.0
    sides = [_segment_distance(p[i], p[i - 1], q[j], q[j - 1]) for i in range(3) for j in range(3)]
    return min(*sides, *(_corner_distance(c, q) for c in p), *(_corner_distance(c, p) for c in q))


def _segment_distance(a: F64, b: F64, c: F64, d: F64) -> float:
    """Result from the stationary point of the squared distance if it lies inside, else from the ends."""
    u, v, w = b - a, d - c, a - c
    ends = [_to_segment(a, c, d), _to_segment(b, c, d), _to_segment(c, a, b), _to_segment(d, a, b)]
    matrix = np.array([[u @ u, -u @ v], [-u @ v, v @ v]])
    if np.linalg.det(matrix) > 1e-12 * matrix[0, 0] * matrix[1, 1]:
        s, t = np.linalg.solve(matrix, [-u @ w, v @ w])
        if 0 <= s <= 1 and 0 <= t <= 1:
            ends.append(float(np.linalg.norm(w + s * u - t * v)))
    return min(ends)


def _to_segment(point: F64, a: F64, b: F64) -> float:
    along = b - a
    share = np.clip((point - a) @ along / max(along @ along, 1e-300), 0, 1)
    return float(np.linalg.norm(point - a - share * along))


def _barycentric(point: F64, triangle: F64) -> F64 | None:
    """Coordinates of the projection of a point; None for a triangle without area."""
    edges = np.stack([triangle[1] - triangle[0], triangle[2] - triangle[0]], axis=1)
    if np.linalg.matrix_rank(edges) < 2:
        return None
    s, t = np.linalg.lstsq(edges, point - triangle[0], rcond=None)[0]
    return np.array([1 - s - t, s, t])


def _corner_distance(point: F64, triangle: F64) -> float:
    shares = _barycentric(point, triangle)
    if shares is None or (shares < 0).any():
        return float("inf")
    return float(np.linalg.norm(point - shares @ triangle))


def _crosses(a: F64, b: F64, triangle: F64) -> bool:
    normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    over, under = (a - triangle[0]) @ normal, (b - triangle[0]) @ normal
    if over * under >= 0:
        return False
    shares = _barycentric(a + (b - a) * (over / (over - under)), triangle)
    return shares is not None and bool((shares >= 0).all())
