"""JSON and OBJ files of procedural shapes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from kinmo.core.shape import Mesh


def write_json(path: Path, content: Any) -> None:
    """Write plain data as JSON."""
    path.write_text(json.dumps(content), encoding="utf-8")


def write_obj(path: Path, mesh: Mesh) -> None:
    """Write a mesh as OBJ, with six decimals per coordinate."""
    vertices = ("v %.6f %.6f %.6f\n" * len(mesh.vertices)) % tuple(mesh.vertices.ravel().tolist())
    faces = ("f %d %d %d\n" * len(mesh.faces)) % tuple((mesh.faces.astype(int) + 1).ravel().tolist())
    path.write_text(f"o {path.stem}\n{vertices}{faces}", encoding="ascii")


def rounded(values: Any) -> list[float]:
    """A vector [N] as JSON numbers with 12 significant digits."""
    return [float(f"{value:.12g}") + 0.0 for value in values]
