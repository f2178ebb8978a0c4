"""PLY with faces: one mesh, which is split into loose pieces. PLY files with points alone are scans."""

from __future__ import annotations

import re
from pathlib import Path

from kinmo.core.shape import Shape
from kinmo.io.readers.ply_mesh import read_ply_mesh
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import Scene, SceneBuilder
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, is_pointer, peek, read_bytes

PLY = "ply"
_FACES = re.compile(rb"^element[ \t]+face[ \t]+0*[1-9]", re.MULTILINE)


def read_ply(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a PLY file (see `shape_of_scene`)."""
    return shape_of_scene(read_ply_scene(Path(path)), facts)


def read_ply_scene(path: Path) -> Scene:
    """The scene of a PLY file: one node without a name."""
    builder = SceneBuilder(path)
    builder.add("", mesh=read_ply_mesh(read_bytes(path, path.parent, MAX_SCENE_BYTES), path, builder.ignore))
    return builder.scene(PLY, "PLY", "z", None)


def has_faces(path: Path) -> bool:
    """True if the header of a PLY file announces faces."""
    begin = peek(path, path.parent)
    return begin.startswith(b"ply") and _FACES.search(begin.replace(b"\r", b"\n").partition(b"end_header")[0]) is not None


_id_by_ending = id_by_ending((".ply",))


def _id_of_file(path: Path) -> str | None:
    name = _id_by_ending(path)
    return name if name is not None and (has_faces(path) or is_pointer(peek(path, path.parent))) else None


READER = Reader(
    PLY,
    read_ply,
    lambda path: (path.absolute().parent, [path]),
    id_of_file=_id_of_file,
    endings=(".ply",),
    read_stated=read_ply,
    is_bare_mesh=True,
)
