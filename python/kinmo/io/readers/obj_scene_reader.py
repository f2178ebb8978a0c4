"""Wavefront OBJ as a scene: its objects (`o`), groups (`g`) or materials (`usemtl`) are the parts.

kinmo reads OBJ itself. trimesh loses objects and groups where materials divide them too, and makes repeated names unique.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.frames import Axis
from kinmo.core.mesh_splitting import split_mesh
from kinmo.core.shape import Mesh, Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers.mtl_materials import MtlMaterials
from kinmo.io.readers.obj_reader import face_places, material_files, obj_lines, parse_polygons
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import Scene, SceneBuilder
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes

OBJ = "obj"
_DIVISION = re.compile(rb"\n[ \t]*(o|g|usemtl)(?=[ \t\n])[ \t]*([^\n#]*)")
_LINES = re.compile(rb"\n[ \t]*[lp][ \t]")
_NEAR = 0.01
"""Distance from the origin, relative to the diagonal, at which an object stands on the ground."""

Keys = NDArray[np.int64]


def read_obj_file(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read an OBJ file (see `shape_of_scene`)."""
    return shape_of_scene(read_obj_scene(Path(path)), facts)


def read_obj_scene(path: Path) -> Scene:
    """The scene of an OBJ file.

    Every line `o` begins an object, also if it repeats a name. A repeated `g` continues its group: faces with the same object
    and group form one node. Objects with several groups have those as children. Materials count if nothing else divides the
    faces.
    """
    text = obj_lines(read_bytes(path, path.parent, MAX_SCENE_BYTES))
    builder = SceneBuilder(path)
    found = parse_polygons(text, path, MtlMaterials(path.parent, builder.ignore))
    if found is None:
        raise InputError(path, "no part has geometry: expected faces of three or more corners")
    mesh, polygons = found
    places = face_places(text)[polygons]
    divisions = _divisions(text)
    objects, object_names = _numbers(divisions["o"], places), ["", *(name for _, name in divisions["o"])]
    groups, group_names = _keys(divisions["g"], places)
    if len(np.unique(objects)) == len(np.unique(groups)) == 1:
        groups, group_names = _keys(divisions["usemtl"], places)
        if len(np.unique(groups)) == 1:
            groups, group_names = np.zeros_like(groups), [""]
    if _LINES.search(text):
        builder.ignore("points and lines")
    file_order = _add_nodes(builder, mesh, objects, object_names, groups, group_names)
    return replace(builder.scene(OBJ, "OBJ", obj_up(mesh), None), file_order=file_order)


def _add_nodes(
    builder: SceneBuilder, mesh: Mesh, objects: Keys, object_names: list[str], groups: Keys, group_names: list[str]
) -> Keys | None:
    """Add a node for each pair of object and group, in the order in which the pairs begin, below a node for each object.

    Returns the indices that put the faces of all nodes back in the order of the file. None if no group is continued.
    """
    pairs, first, inverse = np.unique(objects * len(group_names) + groups, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    labels = rank[inverse.ravel()]
    pieces = split_mesh(mesh, labels)
    owners, which = np.divmod(pairs[order], len(group_names))
    alone = np.bincount(owners, minlength=len(object_names)) == 1
    parents: dict[int, int] = {}
    for piece, owner, group in zip(pieces, owners.tolist(), which.tolist(), strict=True):
        name, group_name = object_names[owner], group_names[group]
        if alone[owner]:
            builder.add(name or group_name, mesh=piece)
            continue
        if owner not in parents:
            parents[owner] = builder.add(name)
        builder.add(group_name, parents[owner], piece)
    is_continued = bool(np.any(np.diff(labels) < 0))
    return np.argsort(np.argsort(labels, kind="stable")) if is_continued else None


def _divisions(text: bytes) -> dict[str, list[tuple[int, str]]]:
    """Positions and names of the lines that begin an object, a group or a material."""
    found: dict[str, list[tuple[int, str]]] = {"o": [], "g": [], "usemtl": []}
    for match in _DIVISION.finditer(text):
        name = clean_text(match[2].decode("utf-8", "replace").strip())
        found[match[1].decode()].append((match.start(), name))
    return found


def _numbers(lines: list[tuple[int, str]], places: Keys) -> Keys:
    """Number of the last line above each face, from 1. Number 0 is for faces above all lines."""
    return np.asarray(np.searchsorted(np.array([place for place, _ in lines], np.int64), places))


def _keys(lines: list[tuple[int, str]], places: Keys) -> tuple[Keys, list[str]]:
    """Number of the name that holds at each face, and the names. Number 0 is for faces above all lines."""
    names = list(dict.fromkeys(["", *(name for _, name in lines)]))
    number = {name: index for index, name in enumerate(names)}
    values = np.array([0, *(number[name] for _, name in lines)], np.int64)
    return values[_numbers(lines, places)], names


def obj_up(mesh: Mesh) -> Axis:
    """Axis that points up. OBJ files have y up, but those of CAD tools that stand on z = 0 have z up."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = high - low
    near = _NEAR * float(np.linalg.norm(size))
    stands = np.abs(low) <= near
    is_centred = np.abs(low + high) <= 0.1 * size
    return "z" if stands[2] and is_centred[0] and is_centred[1] and not stands[1] else "y"


READER = Reader(
    OBJ,
    read_obj_file,
    lambda path: (path.absolute().parent, [path, *material_files([path], path.parent)]),
    id_of_file=id_by_ending((".obj",)),
    endings=(".obj",),
    read_stated=read_obj_file,
    is_bare_mesh=True,
)
