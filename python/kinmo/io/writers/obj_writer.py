"""Wavefront OBJ."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Mesh


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write a mesh to an OBJ file, with all digits of its vertices and with its faces as they are."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces.astype(int) + 1).tolist())
    path.write_text(vertices + faces, encoding="ascii")
