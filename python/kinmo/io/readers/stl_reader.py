"""STL: the solids of a text file are the parts. A binary file has one mesh, which is split into loose pieces."""

from __future__ import annotations

import re
from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import Scene, SceneBuilder
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.trimesh_loading import load_meshes
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes

STL = "stl"
MILLIMETRE = 0.001
"""Unit of large STL files, which CAD tools and slicers write."""
_SOLID = re.compile(rb"^[ \t]*solid\b[ \t]*([^\r\n]*)", re.MULTILINE | re.IGNORECASE)


def read_stl(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read an STL file (see `shape_of_scene`)."""
    return shape_of_scene(read_stl_scene(Path(path)), facts)


def read_stl_scene(path: Path) -> Scene:
    """The scene of an STL file: one node for each solid."""
    data = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    meshes = list(load_meshes(data, "stl", path))
    # trimesh makes repeated names unique and invents missing ones
    names = [match.decode("utf-8", "replace").strip() for match in _SOLID.findall(data)] if len(meshes) > 1 else []
    builder = SceneBuilder(path)
    for place, mesh in enumerate(meshes):
        builder.add(names[place] if len(names) == len(meshes) else "", mesh=mesh)
    return builder.scene(STL, "STL", "z", None, MILLIMETRE)


READER = Reader(
    STL,
    read_stl,
    lambda path: (path.absolute().parent, [path]),
    id_of_file=id_by_ending((".stl",)),
    endings=(".stl",),
    read_stated=read_stl,
    is_bare_mesh=True,
)
