"""Small OBJ files of several parts."""

from __future__ import annotations

from pathlib import Path

from kinmo.core.shape import Shape

TRIANGLE = "v {0} 0 0\nv {0} 1 0\nv {0} 0 1\nf -3 -2 -1\n"


def obj(path: Path, *lines: str) -> Path:
    """An OBJ file with a triangle after each line, each one at another place."""
    path.write_text("".join(f"{line}\n{TRIANGLE.format(i)}" for i, line in enumerate(lines)), encoding="utf-8")
    return path


def places_of_parts(shape: Shape) -> list[set[int]]:
    """The places in the file of the triangles of each part, from a shape of such a file."""
    return sorted((set(mesh.vertices[:, 0].astype(int).tolist()) for mesh in shape.meshes()), key=min)
