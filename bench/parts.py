"""Part meshes for the benches: those of real objects where there are any, else procedural solids."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

MeshArrays = tuple[NDArray[np.float64], NDArray[np.uint32]]


def real_parts(data: Path) -> list[MeshArrays]:
    """The leaf parts of every PartNet(-Mobility) object below `data`, in a fixed order."""
    return [part for result in sorted(data.rglob("result.json")) for part in _leaf_parts(result)]


def procedural_parts(count: int, seed: int = 0) -> list[MeshArrays]:
    """Boxes, cylinders, capsules, rings, flat plates and lumps, turned and placed at random."""
    rng = np.random.default_rng(seed)
    parts = []
    for index in range(count):
        size = rng.uniform(0.05, 1.0, 3)
        makers = [
            lambda s=size: trimesh.creation.box(s),
            lambda s=size: trimesh.creation.cylinder(s[0], s[1], sections=32),
            lambda s=size: trimesh.creation.capsule(s[1], s[0], count=(16, 16)),
            lambda s=size: trimesh.creation.torus(s[0] + s[1], s[0], 24, 16),
            lambda s=size: trimesh.creation.box((s[0], s[1], 0.0)),
            lambda: trimesh.convex.convex_hull(rng.normal(size=(60, 3))),
        ]
        mesh = makers[index % len(makers)]()
        rotation = trimesh.transformations.random_rotation_matrix(rng.uniform(size=3))[:3, :3]
        parts.append((mesh.vertices @ rotation.T + rng.normal(size=3), mesh.faces.astype(np.uint32)))
    return parts


def load_parts(data: Path, limit: int | None) -> tuple[list[MeshArrays], str]:
    """Real parts if `data` has any, else procedural ones, and a line that says which."""
    parts = real_parts(data) if data.is_dir() else []
    if parts:
        return parts[: limit or None], f"leaf parts of the real objects below {data}"
    return procedural_parts(limit or 600), f"procedural parts ({data} has no objects)"


def is_curved(vertices: NDArray[np.float64], faces: NDArray[np.uint32]) -> bool:
    """Whether more than a quarter of the surface faces none of the axes of the file (within 10 degrees)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    if areas.sum() == 0.0:
        return False
    facing = np.abs(normals).max(axis=1) > np.cos(np.radians(10.0)) * areas
    return float(areas[~facing].sum() / areas.sum()) > 0.25


def _leaf_parts(result: Path) -> Iterator[MeshArrays]:
    pending: list[dict[str, Any]] = list(json.loads(result.read_text()))
    folder = result.parent / "textured_objs"
    while pending:
        node = pending.pop()
        pending.extend(node.get("children", []))
        names = [name for name in node.get("objs", []) if (folder / f"{name}.obj").is_file()]
        if names and not node.get("children"):
            part = _join([_read_obj(folder / f"{name}.obj") for name in names])
            if len(part[1]):
                yield part


def _read_obj(path: Path) -> MeshArrays:
    """Vertices and triangles of an OBJ; polygons are cut into fans."""
    vertices, faces = [], []
    for line in path.read_text(errors="replace").splitlines():
        if line.startswith("v "):
            vertices.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            corners = [int(word.split("/")[0]) for word in line.split()[1:]]
            corners = [i - 1 if i > 0 else len(vertices) + i for i in corners]
            faces.extend([corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1))
    return np.array(vertices, float).reshape(-1, 3), np.array(faces, np.uint32).reshape(-1, 3)


def _join(meshes: list[MeshArrays]) -> MeshArrays:
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])[:-1]
    faces = [mesh[1] + np.uint32(offset) for mesh, offset in zip(meshes, offsets, strict=True)]
    return np.concatenate([vertices for vertices, _ in meshes]), np.concatenate(faces)
