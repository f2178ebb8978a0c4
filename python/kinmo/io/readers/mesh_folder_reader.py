"""A folder of mesh files (OBJ, PLY, STL): each file is a part of one shape."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Set as AbstractSet
from dataclasses import replace
from pathlib import Path

from kinmo.core.shape import Shape, join
from kinmo.core.wording import counted
from kinmo.io.readers.dae_reader import READER as DAE_READER
from kinmo.io.readers.gltf_reader import READER as GLB_READER
from kinmo.io.readers.obj_scene_reader import obj_up, read_obj_scene
from kinmo.io.readers.ply_reader import READER as PLY_READER
from kinmo.io.readers.ply_reader import read_ply_scene
from kinmo.io.readers.reader import Reader, SourceFiles
from kinmo.io.readers.scene import Scene, SceneBuilder
from kinmo.io.readers.scene_shape import shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.stl_reader import MILLIMETRE, read_stl_scene
from kinmo.io.readers.threemf_reader import READER as THREEMF_READER
from kinmo.io.readers.untrusted_files import peek
from kinmo.io.readers.usd_reader import READER as USD_READER

MESH_FOLDER = "mesh_folder"
_SCENE_READERS = {".obj": read_obj_scene, ".ply": read_ply_scene, ".stl": read_stl_scene}
_WHOLE_SHAPES = tuple(ending for reader in (GLB_READER, USD_READER, DAE_READER, THREEMF_READER) for ending in reader.endings)
"""Endings of files that are shapes of their own."""
_DIVISION = re.compile(rb"^[ \t]*(o|g)[ \t]+([^\r\n]+)", re.MULTILINE)


def read_mesh_folder(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a folder of mesh files (see `shape_of_scene`). The name of a file without its ending is the name of the part."""
    return shape_of_scene(_read_scene(Path(path)), facts)


def _read_scene(folder: Path) -> Scene:
    builder = SceneBuilder(folder)
    files = _mesh_files(folder, {entry.name for entry in folder.iterdir()})
    scenes = [_SCENE_READERS[file.suffix.lower()](file) for file in files]
    meshes = [join(*(node.mesh for node in scene.nodes if node.mesh is not None)) for scene in scenes]
    for file, mesh in zip(files, meshes, strict=True):
        builder.add(file.stem, mesh=mesh)
    endings = {file.suffix.lower() for file in files}
    up = obj_up(join(*meshes)) if ".obj" in endings else "z"
    found = builder.scene(MESH_FOLDER, counted(len(files), "mesh file"), up, None, MILLIMETRE if endings == {".stl"} else None)
    return replace(found, unread=sum((Counter(scene.unread) for scene in scenes), Counter()))


def _mesh_files(folder: Path, names: AbstractSet[str]) -> list[Path]:
    shown = sorted(name for name in names if not name.startswith("."))
    return [folder / name for name in shown if Path(name).suffix.lower() in _SCENE_READERS and (folder / name).is_file()]


def _is_shape_folder(folder: Path, names: AbstractSet[str]) -> bool:
    """True for a folder with two or more mesh files of different names that are parts, not shapes of their own."""
    endings = [Path(name).suffix.lower() for name in names]
    if sum(ending in _SCENE_READERS for ending in endings) < 2 or any(ending in _WHOLE_SHAPES for ending in endings):
        return False
    files = _mesh_files(folder, names)
    if len({file.stem for file in files}) < max(len(files), 2):  # one object in several formats
        return False
    return not any(_is_whole(file) for file in files)


def _is_whole(file: Path) -> bool:
    """True for an OBJ file with several objects or groups, and for a scan."""
    if file.suffix.lower() == ".ply":
        return PLY_READER.id_of_file(file) is None
    if file.suffix.lower() != ".obj":
        return False
    found = _DIVISION.findall(peek(file, file.parent))
    groups = {name for key, name in found if key == b"g"}  # a repeated group is one, but repeated objects are several
    return sum(key == b"o" for key, _ in found) + len(groups) > 1


def _source_files(path: Path) -> SourceFiles:
    return path.absolute().parent, _mesh_files(path, {entry.name for entry in path.iterdir()})


READER = Reader(
    MESH_FOLDER,
    read_mesh_folder,
    _source_files,
    is_shape_folder=_is_shape_folder,
    read_stated=read_mesh_folder,
    is_bare_mesh=True,
)
