"""Looks of surfaces: materials with images, texture coordinates, colours and normals.

A look belongs to the faces of a mesh, so that it survives whatever joins, splits or reorders them. Colours are the numbers of
the file: no colour space is converted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

AlphaMode = Literal["OPAQUE", "MASK", "BLEND"]
"""Use of the opacity: none, a threshold, or transparency."""
WHITE = (1.0, 1.0, 1.0, 1.0)
NO_MATERIAL = -1
"""Index of the material of faces that have none."""


@dataclass(frozen=True)
class Image:
    """An encoded image, such as the content of a PNG file.

    Attributes:
        data: the bytes.
        mime: their type, such as "image/png".
        name: name in the file, without folder. It may be empty.
    """

    data: bytes
    mime: str
    name: str = ""


@dataclass(frozen=True)
class Material:
    """A material.

    Attributes:
        name: name in the file. It may be empty.
        base_color: red, green, blue and opacity from 0 to 1. The image and the colours of vertices multiply it.
        image: texture of the base colour. It repeats outside of [0, 1].
        metallic: 0 for plastic or wood, 1 for metal.
        roughness: 0 for a mirror, 1 for a matt surface.
        emissive: red, green and blue that it emits.
        double_sided: True if back faces are seen.
        alpha_mode: use of the opacity.
        alpha_cutoff: threshold of "MASK".
    """

    name: str = ""
    base_color: tuple[float, float, float, float] = WHITE
    image: Image | None = None
    metallic: float = 0.0
    roughness: float = 1.0
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)
    double_sided: bool = True
    alpha_mode: AlphaMode = "OPAQUE"
    alpha_cutoff: float = 0.5


@dataclass(frozen=True, eq=False)
class Look:
    """The look of the F faces of a mesh.

    Attributes:
        materials: the materials.
        material: [F] int32, index of the material of each face, or `NO_MATERIAL`.
        uvs: [F, 3, 2] float64, texture coordinates of each corner. (0, 0) is the lower left of the image.
        colors: [F, 3, 4] float32, red, green, blue and opacity of each corner.
        normals: [F, 3, 3] float32, unit normals of each corner.
    """

    materials: tuple[Material, ...]
    material: NDArray[np.int32]
    uvs: F64 | None = None
    colors: F32 | None = None
    normals: F32 | None = None

    def of_faces(self, chosen: NDArray[Any]) -> Look:
        """The look of some faces, with their materials alone. `chosen` has their indices, or True for them."""
        own = self.material[chosen]
        used, places = np.unique(own, return_inverse=True)
        numbers = used[used != NO_MATERIAL].tolist()
        places = places.reshape(own.shape) + (len(numbers) - len(used))  # `NO_MATERIAL` comes first in `used`
        return Look(
            tuple(self.materials[number] for number in numbers),
            places.astype(np.int32),
            None if self.uvs is None else self.uvs[chosen],
            None if self.colors is None else self.colors[chosen],
            None if self.normals is None else self.normals[chosen],
        )

    @property
    def flipped(self) -> Look:
        """The look of the same faces with their corners in reverse order, and their normals to the other side."""
        return Look(
            self.materials,
            self.material,
            None if self.uvs is None else self.uvs[:, ::-1],
            None if self.colors is None else self.colors[:, ::-1],
            None if self.normals is None else -self.normals[:, ::-1],
        )

    def moved(self, linear: F64) -> Look:
        """The look of faces that a linear map [3, 3] moves: normals turn as the cross products of edges do."""
        if self.normals is None:
            return self
        first, second, third = linear.T
        with np.errstate(all="ignore"):
            cofactors = np.stack([np.cross(second, third), np.cross(third, first), np.cross(first, second)])
            normals = self.normals @ cofactors
            normals = normals / np.linalg.norm(normals, axis=2, keepdims=True)
        if not np.isfinite(normals).all():
            return replace(self, normals=None)
        return replace(self, normals=normals.astype(np.float32))

    @property
    def is_plain(self) -> bool:
        """True without materials and colours of vertices."""
        return self.colors is None and not (self.material != NO_MATERIAL).any()

    def used(self) -> list[tuple[Material | None, NDArray[np.bool_]]]:
        """The materials that faces have, in order, and True for each face [F] of that material."""
        numbers = np.unique(self.material).tolist()
        return [(None if i == NO_MATERIAL else self.materials[i], self.material == i) for i in numbers]


def face_normals(triangles: F64) -> F64:
    """Unit normals [F, 3] of triangles [F, 3, 3]. That of a triangle without an area is the z axis."""
    a, b, c = (triangles[:, corner] for corner in range(3))
    with np.errstate(all="ignore"):
        normals = np.cross(b - a, c - a)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        return np.where(lengths > 0.0, normals / lengths, (0.0, 0.0, 1.0))


def plain_look(triangles: F64) -> Look:
    """The look of triangles [F, 3, 3] without any: no material, and normals across the faces."""
    normals = np.repeat(face_normals(triangles)[:, None], 3, axis=1).astype(np.float32)
    return Look((), np.full(len(triangles), NO_MATERIAL, np.int32), normals=normals)


def join_looks(looks: Sequence[Look | None], triangles: Sequence[F64]) -> Look | None:
    """One look of the faces of some meshes. `triangles` has the corners [F, 3, 3] of each. None if no mesh has a look.

    Equal materials become one. What a mesh lacks and another has is filled in: white, (0, 0), and normals across the faces.
    """
    if not any(look is not None for look in looks):
        return None
    number: dict[Material, int] = {}
    rows: list[NDArray[np.int32]] = []
    for look, own in zip(looks, triangles, strict=True):
        if look is None:
            rows.append(np.full(len(own), NO_MATERIAL, np.int32))
        else:
            indices = [number.setdefault(material, len(number)) for material in look.materials]
            rows.append(np.array([*indices, NO_MATERIAL], np.int32)[look.material])

    def joined(name: str, width: int, fill: float, dtype: type) -> NDArray[Any] | None:
        found = [None if look is None else getattr(look, name) for look in looks]
        if all(each is None for each in found):
            return None
        if name == "normals":
            pairs = zip(found, triangles, strict=True)
            return np.concatenate([plain_look(own).normals if each is None else each for each, own in pairs])
        blanks: list[NDArray[Any]] = [np.full((len(own), 3, width), fill, dtype) for own in triangles]
        return np.concatenate([blank if each is None else each for each, blank in zip(found, blanks, strict=True)])

    return Look(
        tuple(number),
        np.concatenate(rows),
        joined("uvs", 2, 0.0, np.float64),
        joined("colors", 4, 1.0, np.float32),
        joined("normals", 3, 0.0, np.float32),
    )
