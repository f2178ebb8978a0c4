"""Hash of a shape, to notice that its file has changed."""

from __future__ import annotations

import json
from hashlib import blake2b

import numpy as np

from kinmo.core.shape import Shape

_STEPS = 1e6
"""Resolution of vertices, in steps per diagonal. It is far above rounding errors."""
_OFFSET = 0.27182818
"""Fraction of a step by which the borders between steps are moved: round coordinates, which people choose, lie on no border."""


def shape_digest(shape: Shape) -> str:
    """Hash of the hierarchy, the names and the meshes of a shape: 32 hexadecimal digits. Its id and its place do not count."""
    hashed = blake2b(digest_size=16)
    parts = [(part.id, part.name, part.parent) for part in shape.parts]
    hashed.update(json.dumps(parts, separators=(",", ":")).encode())
    center, diagonal = shape.center, shape.diagonal
    for mesh in shape.meshes():
        steps = np.floor((mesh.vertices - center) / diagonal * _STEPS + _OFFSET)
        for array in (steps.astype("<i8"), mesh.faces.astype("<u4")):
            hashed.update(f"{array.shape}".encode())
            hashed.update(array.tobytes())
    return hashed.hexdigest()
