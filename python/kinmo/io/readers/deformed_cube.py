"""DSG-Net's part geometry: a cube mesh with one deformation gradient per vertex.

A part is stored as a rotation (its logarithm, 3 numbers) and a symmetric stretch (6 numbers) for each of the P vertices of a
cube. The deformed vertices v solve the least squares problem (v_i - v_j) = (T_i + T_j)/2 (u_i - u_j) over the cube's edges,
where u are the undeformed vertices. The solution has no fixed position: the box of the part gives it.

The file cube_meshinfo.mat holds the arrays of the solver:

- `neighbour` [P, D]: Vertices along the edges, counted from 1, or 0 for none.
- `vdiff` [P, D, 3]: Weighted differences u_i - u_j.
- `recon` [P, P]: The matrix of the solver.
- `ref_F` [F, 3]: Faces, with vertices counted from 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.array_reader import read_mat

Array = NDArray[np.float64]
_STRETCH = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Position of each entry of the symmetric stretch matrix among its 6 stored numbers."""


@dataclass(frozen=True, eq=False)
class CubeMesh:
    """The undeformed cube: the four arrays of its file, with vertices counted from 0, or -1 for none."""

    neighbours: NDArray[np.int64]
    differences: Array
    solver: Array
    faces: NDArray[np.uint32]

    def decode(self, rotation_logs: Array, stretches: Array) -> Array:
        """Vertices [P, 3] in an arbitrary position, from `rotation_logs` [P, 3] and `stretches` [P, 6]."""
        gradients = _rotations(rotation_logs) @ stretches[:, _STRETCH]
        padded = np.concatenate([gradients, np.zeros((1, 3, 3))])
        sums = padded[self.neighbours] + gradients[:, None]
        right_side = np.einsum("pdij,pdj->pi", sums, self.differences)
        return np.asarray(self.solver @ right_side)


def read_cube_mesh(path: Path, folder: Path) -> CubeMesh:
    """Read cube_meshinfo.mat, which must be inside `folder`. Raises InputError if its arrays do not fit together."""
    data = read_mat(path, folder, ("neighbour", "vdiff", "recon", "ref_F"))
    solver, neighbours, differences, faces = data["recon"], data["neighbour"], data["vdiff"], data["ref_F"]
    if solver.ndim != 2 or solver.shape[0] != solver.shape[1]:
        raise InputError(path, "expected a square matrix", "recon")
    count = len(solver)
    if neighbours.ndim != 2 or neighbours.shape[0] != count or differences.shape != (*neighbours.shape, 3):
        raise InputError(path, f"expected [{count}, D] neighbours and their differences", "vdiff")
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.all((faces >= 1) & (faces <= count)):
        raise InputError(path, f"expected triangles of vertices 1..{count}", "ref_F")
    if not np.all((neighbours >= 0) & (neighbours <= count)):
        raise InputError(path, f"expected vertices 0..{count}", "neighbour")
    if not (np.all(np.isfinite(solver)) and np.all(np.isfinite(differences))):
        raise InputError(path, "expected finite numbers", "recon")
    return CubeMesh(neighbours.astype(np.int64) - 1, differences, solver, (faces - 1).astype(np.uint32))


def place_in_box(vertices: Array, box: Array) -> Array:
    """Vertices [P, 3], moved so that their extent along the axes of a box is centred in it.

    The box [12] is its centre, size, x direction and y direction.
    """
    x, y = (direction / np.linalg.norm(direction) for direction in (box[6:9], box[9:12]))
    axes = np.stack([x, y, np.cross(x, y)])
    along = vertices @ axes.T
    middle = 0.5 * (along.min(axis=0) + along.max(axis=0))
    return np.asarray(vertices - middle @ axes + box[:3])


def _rotations(logs: Array) -> Array:
    """Rotations [P, 3, 3] by Rodrigues' formula, from entries (1,2), (1,3) and (2,3) of their logarithms [P, 3]."""
    skew = np.zeros((len(logs), 3, 3))
    for (row, column), entry in zip(((0, 1), (0, 2), (1, 2)), logs.T, strict=True):
        skew[:, row, column], skew[:, column, row] = entry, -entry
    angle = np.linalg.norm(logs, axis=1)[:, None, None]
    axis = skew / np.where(angle > 0.0, angle, 1.0)
    return np.asarray(np.eye(3) + np.sin(angle) * axis + (1.0 - np.cos(angle)) * (axis @ axis))
