"""Colours of surfaces by their looks: materials, images and colours of vertices.

They are shown as viewers of GLB show them: base colours and colours of vertices are linear, images are not.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.look import NO_MATERIAL, WHITE, Image, Look, Material, join_looks
from kinmo.core.shape import Mesh
from kinmo.view.body_colors import RESTING
from kinmo.view.surface_raster import Fragments
from kinmo.view.texture import Texture

F64 = NDArray[np.float64]

GAMMA = 1.0 / 2.2
"""Exponent from linear colours to those of a screen."""
OPAQUE = 0.999
"""Least opacity that lets nothing through."""

Note = Callable[[str], None]
"""Receives one line about an image that cannot be shown."""


def has_varied_looks(meshes: Iterable[Mesh]) -> bool:
    """True if an image or more than one colour is on some meshes. One colour for all tells nothing apart."""
    found: set[tuple[float, ...]] = set()
    for mesh in meshes:
        look = mesh.look
        if look is None:
            found.add(WHITE)
            continue
        tints = np.ones((1, 4)) if look.colors is None else np.asarray(look.colors.reshape(-1, 4), float)
        for material, faces in look.used():
            if material is not None and material.image is not None and look.uvs is not None:
                return True
            own = tints if len(tints) == 1 else tints[np.repeat(faces, 3)]
            if (own != own[0]).any():
                return True
            base = np.array(WHITE if material is None else material.base_color)
            found.add(tuple((base * own[0]).round(3).tolist()))
    return len(found) > 1


class SurfaceColors:
    """The colours of some parts at any place of their surfaces.

    Args:
        meshes: The surface of each part.
        note: What receives a line about an image that cannot be shown.
    """

    def __init__(self, meshes: Sequence[Mesh], note: Note = lambda line: None) -> None:
        looks = [None if mesh.look is None else replace(mesh.look, normals=None) for mesh in meshes]
        joined = join_looks(looks, [mesh.triangles for mesh in meshes])
        count = sum(len(mesh.faces) for mesh in meshes)
        self._look = Look((), np.full(count, NO_MATERIAL, np.int32)) if joined is None else joined
        self._textures: dict[Image, Texture | None] = {}
        for material in self._look.materials:
            if self._look.uvs is not None and material.image is not None and material.image not in self._textures:
                self._textures[material.image] = _texture(material.image, note)

    @property
    def is_see_through(self) -> NDArray[np.bool_]:
        """True for each triangle [T] that may show what is behind it."""
        look = self._look
        found = np.zeros(len(look.material), bool)
        faint = found if look.colors is None else (look.colors[..., 3] < OPAQUE).any(axis=1)
        for number, material in enumerate(look.materials):
            if material.alpha_mode != "OPAQUE":
                texture = self._texture_of(material)
                is_faint = material.base_color[3] < OPAQUE or (texture is not None and not texture.is_opaque)
                found = found | ((look.material == number) & (faint | is_faint))
        return found

    def at(self, fragments: Fragments) -> F64:
        """Red, green, blue and opacity [N, 4] of the samples where something is seen, row by row.

        Args:
            fragments: What is seen of the same parts.
        """
        look, triangles = self._look, fragments.triangles[fragments.is_seen]
        found = np.ones((len(triangles), 4))
        if look.colors is not None:
            found = np.einsum("nc,nci->ni", fragments.weights, look.colors[triangles].astype(np.float64))
            found[:, :3] **= GAMMA
        materials = look.material[triangles]
        for number in (np.flatnonzero(np.bincount(materials - NO_MATERIAL)) + NO_MATERIAL).tolist():
            chosen = materials == number
            if number == NO_MATERIAL:
                found[chosen] *= (*RESTING, 1.0) if look.colors is None else WHITE
                continue
            material = look.materials[number]
            red, green, blue, opacity = material.base_color
            found[chosen] *= (red**GAMMA, green**GAMMA, blue**GAMMA, opacity)
            texture = self._texture_of(material)
            if texture is not None and look.uvs is not None:
                own = triangles[chosen]
                uvs = np.einsum("nc,nci->ni", fragments.weights[chosen], look.uvs[own])
                spread = np.sqrt(_texel_areas(look.uvs, texture) / np.maximum(fragments.areas, np.finfo(float).tiny))
                found[chosen] *= texture.at(uvs, spread[own])
            if material.alpha_mode == "OPAQUE":
                found[chosen, 3] = 1.0
            elif material.alpha_mode == "MASK":
                found[chosen, 3] = found[chosen, 3] >= material.alpha_cutoff
        return found

    def _texture_of(self, material: Material) -> Texture | None:
        return None if material.image is None else self._textures.get(material.image)


def _texel_areas(uvs: F64, texture: Texture) -> F64:
    """Areas [N] in texels of triangles with texture coordinates [N, 3, 2]."""
    width, height = texture.size
    first, second = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    return np.asarray(0.5 * width * height * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))


def _texture(image: Image, note: Note) -> Texture | None:
    try:
        return Texture(image)
    except ValueError as error:
        note(f"image {image.name or 'without a name'} left out of the picture, as it cannot be decoded ({error})")
        return None
