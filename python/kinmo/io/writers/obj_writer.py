"""Wavefront OBJ, with its materials as an MTL file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.look import Look, Material
from kinmo.core.names import unique_names
from kinmo.core.shape import Mesh
from kinmo.io.readers.mtl_materials import BRIGHTEST
from kinmo.io.writers.texture_images import TextureImages

PLAIN = "plain"
"""Name of the material of faces that have none, in files that have materials."""


def write_obj(path: Path, mesh: Mesh, textures: TextureImages | None = None, images: str = "") -> None:
    """Write a mesh to an OBJ file, with all digits of its vertices and with its faces as they are.

    Args:
        path: the file. Its materials are written beside it, with the ending .mtl.
        mesh: the mesh.
        textures: what writes the images of its materials. None to write no look.
        images: path of the folder of the images, relative to the file, with a slash at the end.
    """
    look = None if textures is None else mesh.look
    if look is None or textures is None:
        vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
        faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces.astype(int) + 1).tolist())
        path.write_text(vertices + faces, encoding="ascii")
        return
    groups = look.used()
    names = unique_names(PLAIN if material is None else material.name for material, _ in groups)
    head = ""
    if any(material is not None for material, _ in groups):
        head = f"mtllib {path.with_suffix('.mtl').name}\n"
        text = "".join(_material(name, material, textures, images) for name, (material, _) in zip(names, groups, strict=True))
        path.with_suffix(".mtl").write_text(text, encoding="ascii")
    lines, corners = _corners(mesh, look)
    blocks = [head, *lines]
    for name, (_, own) in zip(names, groups, strict=True):
        blocks.append(f"usemtl {name}\n" if head else "")
        blocks += (f"f {a} {b} {c}\n" for a, b, c in corners[own].tolist())
    path.write_text("".join(blocks), encoding="ascii")


def _corners(mesh: Mesh, look: Look) -> tuple[Iterable[str], NDArray[Any]]:
    """The lines of vertices, texture coordinates and normals, and the text [F, 3] of each corner."""
    colors = look.colors
    if colors is None:
        points, faces = mesh.vertices, mesh.faces.astype(np.int64)
        lines = [_line("v", row) for row in points.tolist()]
    else:  # a vertex with two colours becomes two
        rows = np.concatenate([mesh.triangles, colors[..., :3].astype(np.float64)], axis=2).reshape(-1, 6)
        points, places = np.unique(rows, axis=0, return_inverse=True)
        faces = places.reshape(-1, 3)
        lines = [_line("v", row) for row in points.tolist()]
    texts = (faces + 1).astype(str).astype(object)
    for key, values in (("vt", look.uvs), ("vn", look.normals)):
        if values is not None:
            rows, places = np.unique(values.reshape(-1, values.shape[2]), axis=0, return_inverse=True)
            lines += [_line(key, row) for row in rows.tolist()]
            texts = texts + "/" + (places.reshape(-1, 3) + 1).astype(str).astype(object)
        elif key == "vt" and look.normals is not None:
            texts = texts + "/"
    return lines, texts


def _line(key: str, numbers: list[float]) -> str:
    return f"{key} {' '.join(repr(number + 0.0) for number in numbers)}\n"


def _material(name: str, material: Material | None, textures: TextureImages, images: str) -> str:
    """The lines of a material in an MTL file. `Pr` and `Pm` are the usual extension for roughness and metalness."""
    if material is None:
        return f"newmtl {name}\nKd 1.0 1.0 1.0\nKs 0.0 0.0 0.0\n"
    red, green, blue, opacity = material.base_color
    shine = 1.0 - material.roughness
    lines = [
        f"newmtl {name}",
        f"Kd {red!r} {green!r} {blue!r}",
        f"Ks {0.5 * shine!r} {0.5 * shine!r} {0.5 * shine!r}",
        f"Ns {BRIGHTEST * shine**2!r}",
        f"d {opacity!r}",
        f"Pr {material.roughness!r}",
        f"Pm {material.metallic!r}",
    ]
    if any(material.emissive):
        lines.append(f"Ke {' '.join(map(repr, material.emissive))}")
    if material.image is not None and (file := textures.file(material.image)) is not None:
        lines.append(f"map_Kd {images}{file}")
        if material.alpha_mode != "OPAQUE":
            lines.append(f"map_d {images}{file}")
    return "\n".join([*lines, "", ""])
