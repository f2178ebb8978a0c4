"""Meshes of parts for benchmarks: leaf parts of real objects if there are any, else procedural solids."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from kinmo.io.discover import discover

MeshArrays = tuple[NDArray[np.float64], NDArray[np.uint32]]
"""Vertices [V, 3] and triangles [T, 3] of a mesh."""


def real_parts(data: Path) -> list[MeshArrays]:
    """The leaf parts of every PartNet-Mobility object below a folder, in a fixed order."""
    shapes = (source.read() for source in sorted(discover(data), key=lambda source: source.path))
    return [(mesh.vertices, mesh.faces.astype(np.uint32)) for shape in shapes for mesh in shape.meshes()]


def procedural_parts(count: int, seed: int = 0) -> list[MeshArrays]:
    """Boxes, cylinders, capsules, rings, flat plates and random convex hulls, with random rotations and places."""
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
    """Real parts, or procedural ones if there are none, at most `limit`. Also returns a description of them."""
    parts = real_parts(data) if data.is_dir() else []
    if parts:
        return parts[: limit or None], f"leaf parts of the real objects below {data}"
    return procedural_parts(limit or 600), f"procedural parts ({data} has no objects)"


def is_curved(vertices: NDArray[np.float64], faces: NDArray[np.uint32]) -> bool:
    """True if more than a quarter of the surface is more than 10 degrees off all axes of the file."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    if areas.sum() == 0.0:
        return False
    axis_aligned = np.abs(normals).max(axis=1) > np.cos(np.radians(10.0)) * areas
    return float(areas[~axis_aligned].sum() / areas.sum()) > 0.25
