"""STL: the solids of a text file are the parts. A binary file has one mesh, which is split into loose pieces."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import Scene, SceneBuilder
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.trimesh_loading import load_meshes
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes

STL = "stl"
MILLIMETRE = 0.001
"""Unit of large STL files, which CAD tools and slicers write."""
_FACET = re.compile(rb"^[ \t]*facet\s", re.MULTILINE | re.IGNORECASE)
TEXT_START = 1 << 16
"""Bytes at the beginning of a text file that its first triangle is in."""
_HEADER = struct.Struct("<80xI")
"""Begin of a binary file, with the number of triangles."""
TRIANGLE_BYTES = 50
_SOLID = re.compile(rb"^[ \t]*solid\b[ \t]*([^\r\n]*)", re.MULTILINE | re.IGNORECASE)


def read_stl(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read an STL file (see `shape_of_scene`)."""
    return shape_of_scene(read_stl_scene(Path(path)), facts)


def read_stl_scene(path: Path) -> Scene:
    """The scene of an STL file: one node for each solid."""
    data = _triangle_bytes(read_bytes(path, path.parent, MAX_SCENE_BYTES), path)
    meshes = list(load_meshes(data, "stl", path))
    # trimesh makes repeated names unique and invents missing ones
    names = [match.decode("utf-8", "replace").strip() for match in _SOLID.findall(data)] if len(meshes) > 1 else []
    builder = SceneBuilder(path)
    for place, mesh in enumerate(meshes):
        builder.add(names[place] if len(names) == len(meshes) else "", mesh=_joined(mesh))
    return builder.scene(STL, "STL", "z", None, MILLIMETRE)


def _triangle_bytes(data: bytes, path: Path) -> bytes:
    """The file without what some tools write behind the triangles of a binary one.

    Raises InputError for a file that is neither text nor as long as its header says.
    """
    if _FACET.search(data, 0, TEXT_START):
        return data
    if len(data) < _HEADER.size:
        raise InputError(path, "expected an STL file with triangles: export it again")
    length = _HEADER.size + TRIANGLE_BYTES * _HEADER.unpack_from(data)[0]
    if len(data) < length:
        raise InputError(path, f"expected {length} bytes, as its header says, got {len(data)}: export it again")
    return data[:length]


def _joined(mesh: Mesh) -> Mesh:
    """The mesh with each position once. STL has the corners of every triangle."""
    positions = mesh.vertices + 0.0  # no negative zeros
    factors = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
    bits = positions.view(np.uint64)
    hashes = ((bits ^ (bits >> np.uint64(32))) * factors).sum(axis=1)  # float32 leaves the low bits empty
    _, first, places = np.unique(hashes, return_index=True, return_inverse=True)
    if not np.array_equal(positions[first][places.ravel()], positions):  # two positions with one hash
        return mesh
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return Mesh(positions[np.sort(first)], rank[places.ravel()][mesh.faces].astype(np.uint32))


READER = Reader(
    STL,
    read_stl,
    lambda path: (path.absolute().parent, [path]),
    id_of_file=id_by_ending((".stl",)),
    endings=(".stl",),
    read_stated=read_stl,
    is_bare_mesh=True,
)
