"""Geometry of articulated objects, in Rust.

Every function takes and returns NumPy arrays, runs without the GIL on all threads of rayon (`RAYON_NUM_THREADS` bounds
them), gives the same result for a seed whatever the number of threads, and raises ValueError, its text starting with the
argument's name, for NaN, empty meshes, indices out of range and wrong shapes. P is the number of meshes, G of groups.
A group is a list of indices of meshes taken as one part; `groups=None` takes every mesh by itself.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]

Groups = Sequence[Sequence[int]] | None

__version__: str

class Meshes:
    """The triangle meshes of the parts of one shape, checked once.

    `vertices[i]` [V, 3] float64, `faces[i]` [F, 3] uint32. Vertices that no face uses are ignored.
    """

    def __init__(self, vertices: Sequence[F64], faces: Sequence[U32]) -> None: ...
    def __len__(self) -> int: ...
    def areas(self) -> F64:
        """Surface area [P] of every mesh."""

def sample_surface(meshes: Meshes, count: int, seed: int = 0, *, blue_noise: bool = False) -> tuple[F32, F32, U32]:
    """Points on every mesh, uniform by area: points [P, count, 3], unit normals [P, count, 3], face indices [P, count].

    The order within a mesh is random, so that every prefix is uniform too. The draws are stratified by area. A mesh without
    area is sampled along its edges by length (one without length at its vertices), with unit normals perpendicular to them.
    The samples of a mesh depend on the mesh and `seed` alone. With `blue_noise` they are evenly spaced (Yuksel 2015, weighted
    sample elimination). ValueError if a coordinate does not fit single precision.
    """

def fit_boxes(meshes: Meshes, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Boxes of minimum volume: centers [G, 3], axes [G, 3, 3] (unit rows, right-handed), half extents [G, 3].

    Axes are ordered by descending extent; the first two point towards positive coordinates (by their largest component). Of
    boxes of equal volume (to 1e-5) the one most aligned with the coordinate axes is taken. Flat and line-like parts have half
    extents of about zero (at most the rounding of their coordinates) in the missing directions.
    """

def fit_symmetric_boxes(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 100, tolerance: float = 1e-4
) -> tuple[F64, F64, F64, NDArray[np.uint8]]:
    """Boxes of Fish et al. 2014: centers, axes, half extents as of `fit_boxes`, and the number [G] of symmetric planes.

    Of the box of minimum volume and those on the facets of the convex hull, the one of least volume among those with three
    symmetric middle planes, or else two, or else one, or else of all. A plane is symmetric if the 90th percentile of the
    squared distances of `samples` mirrored surface samples to the surface, over the squared diagonal of the part, is below
    `tolerance`.
    """

def fit_aligned_boxes(meshes: Meshes, frame: F64, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Boxes along the rows of `frame` [3, 3] (orthonormal, right-handed), kept in their order: as `fit_boxes`."""

def fit_upright_boxes(meshes: Meshes, up: F64, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Boxes of minimum volume with the third axis along `up` [3] (any length but zero), the first the longer of the others."""

def find_symmetries(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 200, tolerance: float = 0.01
) -> tuple[U32, NDArray[np.uint8], U32, F64, F64, F64]:
    """Mirror planes and rotation axes of every part, as K rows in the order of the groups.

    Returns the group [K], the kind [K] (0 reflection, 1 rotation), the order [K] (of a rotation the finest that holds, 0 if any
    angle does; 2 for reflections), a point [K, 3] and the unit direction [K, 3] of the axis, or normal of the plane, and the
    error [K]: the 90th percentile of the distances of mapped surface samples to the surface over the part's diagonal, which is
    below `tolerance`.
    """
