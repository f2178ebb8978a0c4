"""The look of an OBJ file: texture coordinates, normals, materials, and the colours that some tools write behind vertices."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.look import NO_MATERIAL, Look
from kinmo.io.readers.mtl_materials import MtlMaterials

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

_LIBRARY = re.compile(rb"\n[ \t]*mtllib[ \t]+([^\n#]*)")
_MATERIAL = re.compile(rb"\n[ \t]*usemtl(?=[ \t\n])[ \t]*([^\n#]*)")
_COORDINATES = re.compile(rb"\n[ \t]*vt[ \t]+([^\n#]*)")
_NORMAL = re.compile(rb"\n[ \t]*vn[ \t]+([^\n#]*)")


@dataclass(frozen=True, eq=False)
class Corners:
    """The corners of all faces, one after the other, with indices from 1, or 0 for none. Negative ones count from the last.

    Attributes:
        vertices: [C] indices of vertices.
        coordinates: [C] indices of texture coordinates.
        normals: [C] indices of normals.
        sizes: [P] number of corners of each face.
    """

    vertices: I64
    coordinates: I64
    normals: I64
    sizes: I64


def libraries_in(text: bytes) -> list[str]:
    """The names of the MTL files that OBJ text from `obj_lines` names."""
    return list(dict.fromkeys(match.decode("utf-8", "replace").strip() for match in _LIBRARY.findall(text)))


def obj_look(
    text: bytes, path: Path, corners: Corners, chosen: I64, places: I64, colors: F64 | None, materials: MtlMaterials
) -> Look | None:
    """The look of the triangles of an OBJ file. None if it has none.

    Args:
        text: the text from `obj_lines`.
        path: the file.
        corners: the corners of its faces.
        chosen: [F, 3] indices of the corners of each triangle.
        places: [F] position in the text of the face of each triangle.
        colors: [C, 3] colours of the corners. None without any.
        materials: the materials, and what is told about everything that cannot be read.
    """
    uvs = _values(text, _COORDINATES, corners.coordinates, chosen, places, 2, materials)
    normals = _values(text, _NORMAL, corners.normals, chosen, places, 3, materials)
    if normals is not None:
        with np.errstate(all="ignore"):
            normals = normals / np.linalg.norm(normals, axis=2, keepdims=True)
        normals = normals if np.isfinite(normals).all() else None
    lines = [(match.start(), match[1].decode("utf-8", "replace").strip()) for match in _MATERIAL.finditer(text)]
    known = materials.of(path, libraries_in(text)) if lines else {}
    names = list(known)
    number = {name: index for index, name in enumerate(names)}
    values = np.array([NO_MATERIAL, *(number.get(name, NO_MATERIAL) for _, name in lines)], np.int32)
    own = values[np.searchsorted(np.array([place for place, _ in lines], np.int64), places)]
    used, compact = np.unique(own[own != NO_MATERIAL], return_inverse=True)
    own[own != NO_MATERIAL] = compact
    if not len(used) and uvs is None and normals is None and colors is None:
        return None
    if colors is not None:
        colors = np.concatenate([colors[chosen], np.ones((*chosen.shape, 1))], axis=2)
    return Look(
        tuple(known[names[index]] for index in used.tolist()),
        own,
        uvs,
        None if colors is None else colors.astype(np.float32),
        None if normals is None else normals.astype(np.float32),
    )


def _values(
    text: bytes, pattern: re.Pattern[bytes], indices: I64, chosen: I64, places: I64, width: int, materials: MtlMaterials
) -> F64 | None:
    """Values [F, 3, width] of the corners of triangles, from lines of numbers. Corners without any have zeros."""
    if not np.any(indices):
        return None
    what = "texture coordinates" if width == 2 else "normals"
    try:
        table = np.loadtxt(pattern.findall(text), comments=None, usecols=range(width), ndmin=2)
    except (ValueError, IndexError):
        table = np.zeros((0, width))
    found = indices[chosen]
    if np.any(found < 0):
        starts = np.array([match.start() for match in pattern.finditer(text)], np.int64)
        found = np.where(found < 0, np.searchsorted(starts, places)[:, None] + found + 1, found)
    if np.any(found < 0) or np.any(found > len(table)) or not np.isfinite(table).all():
        materials.ignore(f"{what} that are broken")
        return None
    return np.concatenate([np.zeros((1, width)), table])[found]
