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
