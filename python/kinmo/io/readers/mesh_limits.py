"""Limits of coordinates, the same for all formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh

MAX_COORDINATE = 1e12
"""Largest coordinate of a vertex, in any unit: in micrometres, it is a thousand kilometres."""


def checked(mesh: Mesh, where: Path) -> Mesh:
    """The mesh itself. Raises InputError if a coordinate is not finite or above `MAX_COORDINATE`."""
    is_fine = np.abs(mesh.vertices) <= MAX_COORDINATE  # also false for what is no number
    if not is_fine.all():
        value = mesh.vertices[~is_fine][0]
        raise InputError(where, f"expected finite coordinates of at most {MAX_COORDINATE:g}, got {value:g}", "vertices")
    return mesh
