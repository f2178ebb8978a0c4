"""Triangles of polygons, for formats whose faces have any number of corners.

A polygon becomes a fan of triangles around its first corner, or around another one if a fan there would cover more than the
polygon. If no corner has such a fan, ears are cut off until a triangle remains.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

LESS_THAN_A_TRIANGLE = "faces of fewer than three corners"
"""Name for notes of polygons that give no triangle."""
_TOLERANCE = 1e-9
"""Largest overlap of a triangle in the wrong direction, relative to the area of the polygon."""
_MAX_FAN_STARTS = 16
"""Most corners of a polygon that are tried as centres of a fan."""
_MAX_WORK = 300_000_000
"""Most steps of cutting ears in all polygons of a mesh: some ten seconds."""
_FEW_CORNERS = 48
"""Corners up to which a loop is faster than NumPy."""


def triangulate(vertices: F64, corners: I64, sizes: I64, where: Path) -> tuple[I64, I64]:
    """Triangles [F, 3] of polygons, and the polygon [F] of each, in the order of the polygons. Points and lines give none.

    A polygon of n corners gives n - 2 triangles. A polygon that crosses itself may be covered in any way.

    Args:
        vertices: [V, 3].
        corners: vertices of all polygons, one after the other.
        sizes: number of corners of each polygon.
        where: the file, for messages.

    Raises:
        InputError: concave polygons with too many corners.
    """
    starts = np.cumsum(sizes) - sizes
    counts = np.maximum(sizes - 2, 0)
    polygons = np.repeat(np.arange(len(sizes)), counts)
    begins = np.cumsum(counts) - counts
    first = starts[polygons]
    step = np.arange(len(first)) - np.repeat(begins, counts)
    faces = np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)
    if not np.any(sizes > 3):
        return faces, polygons
    wrong = np.flatnonzero(sizes > 3)
    wrong = wrong[~_is_covered(vertices, faces, polygons, len(sizes))[wrong]]
    difficult = []
    for size in np.unique(sizes[wrong]).tolist():
        chosen = wrong[sizes[wrong] == size]
        loops = corners[starts[chosen, None] + np.arange(size)]
        fans, is_done = _best_fans(vertices, loops)
        rows = begins[chosen, None] + np.arange(size - 2)
        faces[rows[is_done]] = fans[is_done]
        difficult += list(zip(loops[~is_done], rows[~is_done], strict=True))
    if sum(len(loop) * (len(loop) + 100) for loop, _ in difficult) > _MAX_WORK:
        raise InputError(where, "concave faces with too many corners: triangulate its meshes")
    for loop, rows in difficult:
        faces[rows] = loop[_cut_ears(_flattened(vertices[loop]))]
    return faces, polygons


def _is_covered(vertices: F64, faces: I64, polygons: I64, count: int) -> NDArray[np.bool_]:
    """True for each of `count` polygons whose triangles all face the same way, so that they cover the polygon alone."""
    areas = _area_vectors(vertices, faces)
    totals = np.stack([np.bincount(polygons, weights=column, minlength=count) for column in areas.T], axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        along = np.einsum("ij,ij->i", areas, totals[polygons])
        is_wrong = along < -_TOLERANCE * np.einsum("ij,ij->i", totals, totals)[polygons]
    return np.asarray(np.bincount(polygons[is_wrong], minlength=count) == 0)


def _area_vectors(vertices: F64, faces: I64) -> F64:
    """Vectors [..., 3] along the normals of triangles [..., 3], twice as long as their areas."""
    first, second, third = (vertices[faces[..., corner]] for corner in range(3))
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(np.cross(second - first, third - first))


def _best_fans(vertices: F64, loops: I64) -> tuple[I64, NDArray[np.bool_]]:
    """Fans [P, n - 2, 3] of polygons [P, n], and True for each polygon [P] that its fan covers alone."""
    count, size = loops.shape
    step = np.arange(1, size - 1)
    found = np.zeros((count, size - 2, 3), np.int64)
    is_done = np.zeros(count, bool)
    for start in range(1, min(size, _MAX_FAN_STARTS)):
        left = np.flatnonzero(~is_done)
        if not len(left):
            break
        turned = np.roll(loops[left], -start, axis=1)
        fans = np.stack([np.broadcast_to(turned[:, :1], (len(left), size - 2)), turned[:, step], turned[:, step + 1]], axis=2)
        own = np.repeat(np.arange(len(left)), size - 2)
        good = _is_covered(vertices, fans.reshape(-1, 3), own, len(left))
        found[left[good]], is_done[left[good]] = fans[good], True
    return found, is_done


def _flattened(points: F64) -> F64:
    """Corners [n, 3] of a polygon in its plane [n, 2], counter-clockwise."""
    steps = np.arange(len(points) - 2)
    normal = _area_vectors(points, np.stack([np.zeros_like(steps), steps + 1, steps + 2], axis=1)).sum(axis=0)
    length = float(np.linalg.norm(normal))
    if not 0.0 < length < np.inf:
        return np.asarray(points[:, :2])
    z = normal / length
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return np.asarray((points - points[0]) @ np.stack([x, np.cross(z, x)], axis=1))


def _contain(triangle: F64, points: F64) -> bool:
    """True if a counter-clockwise triangle [3, 2] contains one of the points [P, 2] that is not at a corner."""
    is_inside = np.ones(len(points), bool)
    for start, end in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
        edge, offsets = end - start, points - start
        is_inside &= (edge[0] * offsets[:, 1] >= edge[1] * offsets[:, 0]) & np.any(offsets != 0.0, axis=1)
    return bool(is_inside.any())


def _cut_ears(points: F64) -> I64:
    """Triangles [n - 2, 3] of a counter-clockwise polygon [n, 2].

    An ear is a corner whose triangle contains no other corner. A cut changes the triangles of its two neighbours alone, so that
    only those are tried again.
    """
    count = len(points)
    x, y = points.T.tolist()
    after, before = [*range(1, count), 0], [count - 1, *range(count - 1)]
    left = np.ones(count, bool)

    def turn(a: int, b: int, c: int) -> float:
        return float((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a]))

    reflex = {corner for corner in range(count) if turn(before[corner], corner, after[corner]) < 0.0}

    def is_ear(corner: int) -> bool:
        a, b, c = before[corner], corner, after[corner]
        if b in reflex:
            return False
        if turn(a, b, c) == 0.0:
            return True
        if len(reflex) > _FEW_CORNERS:
            return not _contain(points[[a, b, c]], points[np.fromiter(reflex, np.int64, len(reflex))])
        ends = {(x[a], y[a]), (x[b], y[b]), (x[c], y[c])}
        return not any(
            turn(a, b, p) >= 0.0 and turn(b, c, p) >= 0.0 and turn(c, a, p) >= 0.0 and (x[p], y[p]) not in ends for p in reflex
        )

    faces: list[tuple[int, int, int]] = []
    pending = list(range(count - 1, -1, -1))
    while len(faces) < count - 2:
        if pending:
            corner = pending.pop()
            if not left[corner] or not is_ear(corner):
                continue
        else:
            corner = int(np.argmax(left))  # without an ear, the polygon crosses itself
        a, c = before[corner], after[corner]
        faces.append((a, corner, c))
        left[corner] = False
        reflex.discard(corner)
        after[a], before[c] = c, a
        for end in (c, a):
            if turn(before[end], end, after[end]) >= 0.0:
                reflex.discard(end)
            pending.append(end)
    return np.array(faces, np.int64)
