"""A folder of mesh files (OBJ, PLY, STL): each file is a part of one shape."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from dataclasses import replace
from pathlib import Path

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.wording import clean_text, counted
from kinmo.io.readers.dae_reader import READER as DAE_READER
from kinmo.io.readers.gltf_reader import READER as GLB_READER
from kinmo.io.readers.image_files import MAX_NAMED
from kinmo.io.readers.obj_reader import material_files, obj_lines
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
    """Read a folder of mesh files (see `shape_of_scene`). The name of a file without its ending is the name of the part.

    A file that is broken or has no faces is skipped with a note, and so is each further file of the same name.
    """
    return shape_of_scene(_read_scene(Path(path)), facts)


def _read_scene(folder: Path) -> Scene:
    builder = SceneBuilder(folder)
    found: dict[Path, Mesh] = {}
    unread: Counter[str] = Counter()
    problems: list[str] = []
    for file in _mesh_files(folder, {entry.name for entry in folder.iterdir()}):
        try:
            scene = _read_file(file, found)
            found[file] = scene.whole
            unread += Counter(scene.unread)
        except InputError as error:
            problems.append(f"mesh file {clean_text(file.name)} ({error.problem})")
    if not found:
        raise InputError(folder, f"no mesh file can be read: {'; '.join(problems[:1])}")
    unread.update(problems[:MAX_NAMED])
    unread["further mesh files that cannot be read"] = len(problems[MAX_NAMED:])
    for file, mesh in found.items():
        builder.add(file.stem, mesh=mesh)
    endings = {file.suffix.lower() for file in found}
    up = obj_up(join(*found.values())) if ".obj" in endings else "z"
    unit = MILLIMETRE if endings == {".stl"} else None
    return replace(builder.scene(MESH_FOLDER, counted(len(found), "mesh file"), up, None, unit), unread=unread)


def _read_file(file: Path, others: Iterable[Path]) -> Scene:
    """The scene of a mesh file. Raises InputError if it has no faces, or if another file has its name."""
    if (same := next((other for other in others if other.stem == file.stem), None)) is not None:
        raise InputError(file, f"{same.name} has the same name")
    scene = _SCENE_READERS[file.suffix.lower()](file)
    if not any(node.mesh is not None and len(node.mesh.faces) for node in scene.nodes):
        raise InputError(file, "has no faces")
    return scene


def _mesh_files(folder: Path, names: AbstractSet[str]) -> list[Path]:
    shown = sorted(name for name in names if not name.startswith("."))
    return [folder / name for name in shown if Path(name).suffix.lower() in _SCENE_READERS and (folder / name).is_file()]


def _is_shape_folder(folder: Path, names: AbstractSet[str]) -> bool:
    """True for a folder with mesh files of two or more names that are parts, not shapes of their own.

    Some files may be no parts: PLY files without faces, and files of the same name, which are one object in several formats.
    But meshes that are alone in their name must outnumber these. Otherwise the folder has scans or objects.
    """
    endings = [Path(name).suffix.lower() for name in names]
    if sum(ending in _SCENE_READERS for ending in endings) < 2 or any(ending in _WHOLE_SHAPES for ending in endings):
        return False
    files = _mesh_files(folder, names)
    meshes = [file for file in files if file.suffix.lower() != ".ply" or PLY_READER.id_of_file(file) is not None]
    counts = Counter(file.stem for file in meshes)
    alone = sum(count == 1 for count in counts.values())
    if len(counts) < 2 or alone <= len(counts) - alone + len(files) - len(meshes):
        return False
    return not any(_has_several_objects(file) for file in meshes)


def _has_several_objects(file: Path) -> bool:
    """True for an OBJ file with several objects or groups."""
    if file.suffix.lower() != ".obj":
        return False
    found: list[tuple[bytes, bytes]] = _DIVISION.findall(obj_lines(peek(file, file.parent)))
    groups = {name for key, name in found if key == b"g"}  # a repeated group is one, but repeated objects are several
    return sum(key == b"o" for key, _ in found) + len(groups) > 1


def _source_files(path: Path) -> SourceFiles:
    files = _mesh_files(path, {entry.name for entry in path.iterdir()})
    return path.absolute().parent, [*files, *material_files(files, path)]


READER = Reader(
    MESH_FOLDER,
    read_mesh_folder,
    _source_files,
    is_shape_folder=_is_shape_folder,
    read_stated=read_mesh_folder,
    is_bare_mesh=True,
)
