"""Meshes of file formats that trimesh reads without losing anything that kinmo needs."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh


def load_meshes(data: bytes, file_type: str, path: Path) -> Iterator[Mesh]:
    """The triangle meshes of a file, in its order and with its vertices. Raises InputError for broken files.

    Args:
        data: content of the file.
        file_type: its format, as trimesh names it.
        path: the file, for messages.
    """
    import trimesh

    try:
        scene = trimesh.load_scene(io.BytesIO(data), file_type=file_type, process=False, skip_materials=True)
        found = [each for each in scene.geometry.values() if isinstance(each, trimesh.Trimesh)]
        meshes = [(np.array(each.vertices, np.float64), np.array(each.faces, np.int64)) for each in found]
    except Exception as error:  # trimesh raises many kinds of errors for broken files
        raise InputError(path, f"expected a readable {file_type.upper()} file ({type(error).__name__}: {error})") from None
    for vertices, faces in meshes:
        if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise InputError(path, f"a face names a vertex outside 0..{len(vertices) - 1}")
        yield Mesh(vertices, faces.astype(np.uint32))
