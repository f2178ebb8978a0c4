"""Parts of a mesh: by labels of its faces, merging of the smallest parts where there are too many, and by a plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.shape import Mesh

_SAMPLES = 50_000
"""Points on all larger parts together, to which smaller parts are compared."""


def split_mesh(mesh: Mesh, labels: NDArray[np.int64]) -> list[Mesh]:
    """Parts of a mesh by the label [F] of each face, in the order of the labels. The faces of a part stay in their order."""
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order])) + 1
    return [mesh.part(faces) for faces in np.split(order, starts)]


def merge_small_parts(mesh: Mesh, labels: NDArray[np.int64], most: int) -> NDArray[np.int64]:
    """Labels [F] of faces, where all but the `most` parts with the largest area belong to the nearest of those.

    Args:
        mesh: the mesh.
        labels: number of the part of each face, from 0.
        most: number of parts that stay.
    """
    areas = mesh.face_areas
    centers = mesh.triangles.mean(axis=1)
    sizes = np.bincount(labels, weights=areas)
    order = np.argsort(-sizes, kind="stable")
    kept, small = np.sort(order[:most]), np.sort(order[most:])
    if not len(small):
        return labels
    weights = np.maximum(sizes, np.finfo(np.float64).tiny)
    middles = np.column_stack([np.bincount(labels, weights=areas * centers[:, axis]) / weights for axis in range(3)])
    points, faces = _points_on(mesh, np.flatnonzero(np.isin(labels, kept)))
    _, nearest = cKDTree(points).query(middles[small])
    target = np.arange(len(sizes))
    target[small] = labels[faces[nearest]]
    return np.asarray(target[labels], np.int64)


def cut_mesh(mesh: Mesh, normal: NDArray[np.float64], level: float) -> Mesh:
    """The piece of a mesh at or above a plane, without its look.

    Args:
        mesh: the mesh.
        normal: [3] unit vector across the plane.
        level: distance of the plane from the origin along it.
    """
    from trimesh.intersections import slice_faces_plane  # trimesh takes long to import, and few commands need it

    faces = mesh.faces.astype(np.int64)
    vertices, faces, _ = slice_faces_plane(mesh.vertices, faces, normal, level * normal)  # type: ignore[no-untyped-call]
    return Mesh(np.asarray(vertices, np.float64), np.asarray(faces, np.uint32).reshape(-1, 3)).compact


def _points_on(mesh: Mesh, faces: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points [P, 3] on some faces, spread by area, and the face [P] of each. Every part with a face among few has one."""
    rng = np.random.default_rng(0)
    areas = mesh.face_areas[faces]
    chosen = faces if len(faces) <= _SAMPLES else rng.choice(faces, _SAMPLES, replace=False)
    if areas.sum() > 0.0:
        chosen = np.concatenate([chosen, rng.choice(faces, _SAMPLES, p=areas / areas.sum())])
    shares = rng.dirichlet((1.0, 1.0, 1.0), len(chosen))
    return np.einsum("pc,pcx->px", shares, mesh.triangles[chosen]), chosen
