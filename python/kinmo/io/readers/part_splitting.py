"""Parts of a mesh by labels of its faces: splitting, and merging of the smallest parts where there are too many."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes

_SAMPLES = 50_000
"""Points on all larger parts together, to which smaller parts are compared."""


def split_mesh(mesh: Mesh, labels: NDArray[np.int64]) -> list[Mesh]:
    """Parts of a mesh by the label [F] of each face, in the order of the labels. The faces of a part stay in their order."""
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order])) + 1
    parts = []
    for faces in np.split(mesh.faces[order], starts):
        used, places = np.unique(faces, return_inverse=True)
        parts.append(Mesh(mesh.vertices[used], places.reshape(-1, 3).astype(np.uint32)))
    return parts


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


def _points_on(mesh: Mesh, faces: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points [P, 3] on some faces, spread by area, and the face [P] of each. Every part with a face among few has one."""
    rng = np.random.default_rng(0)
    areas = mesh.face_areas[faces]
    chosen = faces if len(faces) <= _SAMPLES else rng.choice(faces, _SAMPLES, replace=False)
    if areas.sum() > 0.0:
        chosen = np.concatenate([chosen, rng.choice(faces, _SAMPLES, p=areas / areas.sum())])
    shares = rng.dirichlet((1.0, 1.0, 1.0), len(chosen))
    return np.einsum("pc,pcx->px", shares, mesh.triangles[chosen]), chosen


def read_labels(path: Path, faces: int, shape: Path) -> NDArray[np.int64]:
    """Labels [F] of the faces of a shape from an .npy file, numbered from 0 in ascending order. Raises InputError."""
    import io

    raw = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    try:
        found = np.load(io.BytesIO(raw), allow_pickle=False)
    except Exception as error:  # NumPy raises many kinds of errors for broken files
        raise InputError(path, f"expected an .npy file with one integer per triangle ({type(error).__name__})") from None
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "iu" or found.size != faces or found.ndim > 2:
        got = f"{list(found.shape)} of {found.dtype}" if isinstance(found, np.ndarray) else "several arrays"
        problem = f"expected {faces} integers, one per triangle of {shape.name} in the order of the file, got {got}"
        raise InputError(path, problem)
    values, labels = np.unique(found, return_inverse=True)
    if len(values) < 2:
        raise InputError(path, "expected at least two labels: every triangle has the same one, so there is one part")
    return np.asarray(labels.ravel(), np.int64)
