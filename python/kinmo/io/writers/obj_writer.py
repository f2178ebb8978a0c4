"""Wavefront OBJ files."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Mesh


def obj_text(mesh: Mesh) -> str:
    """The mesh as OBJ text: every vertex in full precision, every face as it is."""
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist())
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces.astype(int) + 1).tolist())
    return vertices + faces


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write `mesh` to `path`."""
    path.write_text(obj_text(mesh), encoding="ascii")
