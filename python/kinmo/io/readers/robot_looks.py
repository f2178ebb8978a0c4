"""Materials that a robot file gives to its pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinmo.core.look import Image, Look, Material
from kinmo.core.shape import Mesh

INVISIBLE = "materials that are wholly transparent"
"""Lines about parts that would not be seen at all. Such parts have no look."""
SAME_COLOR = 0.01
"""Largest difference of colours that count as one, from 0 to 1."""


def plain_material(
    name: str, color: tuple[float, float, float, float], image: Image | None = None, roughness: float = 1.0
) -> Material:
    """A material that is transparent if its colour is."""
    return Material(name, color, image, roughness=roughness, alpha_mode="BLEND" if color[3] < 1.0 else "OPAQUE")


def has_own_look(mesh: Mesh) -> bool:
    """True if a mesh has materials or colours of vertices."""
    return mesh.look is not None and not mesh.look.is_plain


def with_material(mesh: Mesh, material: Material) -> Mesh:
    """The mesh with one material. It keeps its texture coordinates and normals."""
    count = len(mesh.faces)
    look = Look((), np.zeros(count, np.int32)) if mesh.look is None else mesh.look
    return replace(mesh, look=replace(look, materials=(material,), material=np.zeros(count, np.int32), colors=None))


def has_coordinates(mesh: Mesh) -> bool:
    """True if a mesh has texture coordinates."""
    return mesh.look is not None and mesh.look.uvs is not None


def looks_like(mesh: Mesh, material: Material) -> bool:
    """True if a mesh with a look of its own has the mean colour of a material, and an image if that has one."""
    look = mesh.look
    if look is None or not len(mesh.faces):
        return False
    colors = np.ones((len(mesh.faces), 4))
    for own, faces in look.used():
        if own is not None:
            colors[faces] = own.base_color
    if look.colors is not None:
        colors *= look.colors.mean(axis=1)
    areas = mesh.face_areas
    mean = np.average(colors, axis=0, weights=areas if areas.sum() > 0.0 else None)
    has_image = any(own is not None and own.image is not None for own, _ in look.used())
    return has_image is (material.image is not None) and bool(np.abs(mean - material.base_color).max() < SAME_COLOR)
