"""DSG-Net and StructureNet: one JSON file with the part tree of a shape, and its geometry in other files.

A node of the tree is {id, label, box, children, edges}. The geometry of the leaves of `chair_hier/7.json` is searched in this
order:

1. `chair_obj/7/<leaf id>.obj` (or `chair_objs`), or `7/<leaf id>.obj` beside the tree.
2. The field `geo` of a leaf: a list of points.
3. `chair_geo/7.npz`, or `7.npz` beside the tree: `parts` [N, 1000, 3] by node id. A node with a negative id uses `other_parts`,
   at the position of its parent's id in `other_ids`.
4. `chair_dgeo/7.npz`: deformation gradients `LOGR` [N, P, 3] and `S` [N, P, 6]. They need cube_meshinfo.mat beside that folder.

The boxes and edges of the file are not used, because kinmo computes its own.
"""

from __future__ import annotations

import math
import os
import re
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo.core.categories import canonical_category, same_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.core.wording import clean_text
from kinmo.io.readers.array_reader import read_npz
from kinmo.io.readers.deformed_cube import CubeMesh, place_in_box, read_cube_mesh
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.mesh_limits import checked
from kinmo.io.readers.obj_reader import read_obj
from kinmo.io.readers.part_hierarchy import Node, build_hierarchy, read_nodes
from kinmo.io.readers.reader import Reader, SourceFiles
from kinmo.io.readers.scene import CornerBudget
from kinmo.io.readers.untrusted_files import peek, read_json

Array = NDArray[np.float64]

DSG_NET = "dsg_net"
_SUFFIX = "_hier"
_CUBE_FILE = "cube_meshinfo.mat"
_MIN_POINTS = 4
_NEIGHBOURS = 8
"""Number of nearest neighbours that give the normal and the area of a point."""


def read_dsg_net(path: Path) -> Shape:
    """Read the shape of a part tree, without mobility. Raises InputError if the files cannot be used."""
    path = Path(path)
    geometry = _Geometry(path)
    nodes = read_nodes(read_json(path, geometry.dataset), "label")
    meshes = {}
    for index, node in enumerate(nodes):
        if node.is_leaf:
            meshes[index] = geometry.mesh_of(node, None if node.parent is None else nodes[node.parent].id)
    hierarchy = build_hierarchy(nodes, meshes)
    category, repairs = _category(nodes[0].name, geometry.stem, path)
    return Shape(
        id=_shape_id(path),
        category=category,
        parts=hierarchy.parts,
        source=path,
        layout=DSG_NET,
        partnet_id=path.stem if path.stem.isdecimal() else None,
        repairs=(*repairs, *hierarchy.repairs),
    )


def _shape_id(path: Path) -> str:
    """Name of the tree file. A bare number gets the category in front, because several categories have the same numbers."""
    stem = _Geometry(path).stem
    return clean_text(f"{stem}-{path.stem}" if stem and path.stem.isdecimal() else path.stem)


def _id_of_file(path: Path) -> str | None:
    """The id of the shape if a JSON file is a part tree. In a folder `*_hier` every JSON file is one."""
    if path.suffix != ".json":
        return None
    if not Path(os.path.realpath(path.parent)).name.endswith(_SUFFIX):
        text = peek(path, path.parent)
        has_fields = b'"label"' in text and b'"id"' in text and (b'"children"' in text or b'"box"' in text)
        if not has_fields or not re.match(rb"\s*\{", text):
            return None
    return _shape_id(path)


def _source_files(path: Path) -> SourceFiles:
    return path.absolute().parent.parent, [path, *_Geometry(path).places]


READER = Reader(DSG_NET, read_dsg_net, _source_files, id_of_file=_id_of_file)


def _category(label: str, folder: str, path: Path) -> tuple[str, tuple[str, ...]]:
    """The category by the label of the root or the name of the folder, and a note if they differ."""
    if not label and not folder:
        raise InputError(path, "expected the category", "label")
    if label and folder and not same_category(label, folder):
        text = f"category {canonical_category(label)} taken from the root part, the folder says {clean_text(folder)}"
        return canonical_category(label), (text,)
    return canonical_category(label or clean_text(folder)), ()


class _Geometry:
    """The geometry of the leaves of one tree file.

    Attributes:
        stem: `chair` for a tree in `chair_hier`. Empty in a folder of another name.
        dataset: the folder that geometry files may not lead out of.
        places: all files and folders that may hold geometry, whether they exist or not.
    """

    def __init__(self, path: Path) -> None:
        folder = path.absolute().parent
        self._budget = CornerBudget(path)
        self.stem = folder.name[: -len(_SUFFIX)] if folder.name.endswith(_SUFFIX) else ""
        self.dataset = folder.parent if self.stem else folder
        meshes, arrays = path.stem, f"{path.stem}.npz"
        self._mesh_places = [*self._apart("obj", meshes), path.parent / meshes, *self._apart("objs", meshes)]
        self._point_places = [*self._apart("geo", arrays), path.parent / arrays]
        self._gradient_places = self._apart("dgeo", arrays)
        self.places = [*self._mesh_places, *self._point_places, *self._gradient_places, self.dataset / _CUBE_FILE]

    def _apart(self, kind: str, name: str) -> list[Path]:
        return [self.dataset / f"{self.stem}_{kind}" / name] if self.stem else []

    @cached_property
    def _mesh_folder(self) -> Path | None:
        return next((place for place in self._mesh_places if place.is_dir()), None)

    @cached_property
    def _points(self) -> tuple[Path, dict[str, Array]] | None:
        for place in self._point_places:
            if os.path.lexists(place):
                return place, read_npz(place, self.dataset, ("parts", "other_ids", "other_parts"))
        return None

    @cached_property
    def _gradients(self) -> tuple[Path, dict[str, Array], CubeMesh] | None:
        place = next((place for place in self._gradient_places if place.exists()), None)
        if place is None:
            return None
        cube = self.dataset / _CUBE_FILE
        if not cube.exists():
            raise InputError(place, f"deformation gradients need {_CUBE_FILE} beside their folder, which is missing")
        return place, read_npz(place, self.dataset, ("LOGR", "S")), read_cube_mesh(cube, self.dataset)

    def mesh_of(self, node: Node, parent: int | None) -> Mesh | None:
        """The mesh of a leaf, or None if its OBJ file has no faces. `parent` is the id of the parent node."""
        if self._mesh_folder is not None:
            return read_obj(self._mesh_folder / f"{node.id}.obj", self.dataset)
        inline = node.field["geo"]
        if not inline.is_absent:
            return _mesh_of_points(_inline_points(inline), inline.where, inline.path, self._budget)
        if self._points is not None:
            place, arrays = self._points
            return _mesh_of_points(_stored_points(arrays, node, parent, place), place, f"parts[{node.id}]", self._budget)
        if self._gradients is not None:
            return _deformed_mesh(node, *self._gradients)
        raise node.field.fail("has no geometry: expected an OBJ or points for every leaf")


def _deformed_mesh(node: Node, place: Path, arrays: dict[str, Array], cube: CubeMesh) -> Mesh:
    gradients = []
    for name, width in (("LOGR", 3), ("S", 6)):
        gradients.append(_row(arrays, name, node.id, node, place, width, len(cube.solver)))
        if not np.all(np.isfinite(gradients[-1])):
            raise InputError(place, "expected finite numbers", f"{name}[{node.id}]")
    box = node.field["box"].vector(12)
    if min(np.linalg.norm(box[6:9]), np.linalg.norm(box[9:12])) == 0.0:
        raise node.field["box"].fail("expected two directions, found zero")
    vertices = place_in_box(cube.decode(*gradients), box)
    return checked(Mesh(np.ascontiguousarray(vertices), cube.faces), place)


def _inline_points(field: JsonField) -> Array:
    try:
        points = np.array(field.value, np.float64)
    except (ValueError, TypeError, OverflowError):
        raise field.fail("expected points") from None
    if points.size % 3:
        raise field.fail("expected points of 3 numbers")
    return np.asarray(points.reshape(-1, 3))


def _stored_points(arrays: dict[str, Array], node: Node, parent: int | None, place: Path) -> Array:
    name, index = "parts", node.id
    if node.id < 0:
        name = "other_parts"
        matches = np.flatnonzero(arrays.get("other_ids", np.zeros(0)).ravel() == parent)
        index = int(matches[0]) if len(matches) else -1
    return _row(arrays, name, index, node, place, 3)


def _row(
    arrays: dict[str, Array], name: str, index: int, node: Node, place: Path, width: int, count: int | None = None
) -> Array:
    """Row [count, width] of an array. By default it has any number of points."""
    array = arrays.get(name)
    if array is None or array.ndim != 3 or array.shape[2] != width or count not in (None, array.shape[1]):
        raise InputError(place, f"expected [N, {count or 'n'}, {width}] numbers", name)
    if not 0 <= index < len(array):
        raise InputError(place, f"there is no part {node.id}", name)
    return np.asarray(array[index])


def _mesh_of_points(points: Array, where: Path, field: str, budget: CornerBudget) -> Mesh:
    if len(points) < _MIN_POINTS or not np.all(np.isfinite(points)):
        raise InputError(where, f"expected at least {_MIN_POINTS} finite points", field)
    budget.spend(6 * len(points))
    checked(Mesh(points, np.zeros((0, 3), np.uint32)), where)
    _, first = np.unique(points, axis=0, return_index=True)
    return _surface_of_points(points[np.sort(first)])


def _surface_of_points(points: NDArray[np.float64]) -> Mesh:
    """A mesh with one small equilateral triangle around each point [n, 3] of a sampled surface. No two points are equal.

    Equal points would make a search for neighbours quadratic.

    A triangle lies in the plane of the nearest neighbours of its point and covers the area that belongs to the point. Areas,
    samples, boxes and distances match those of the sampled surface up to the spacing of the samples.
    """
    if len(points) < _MIN_POINTS:
        return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    count = min(_NEIGHBOURS, len(points) - 1)
    distances, indices = cKDTree(points).query(points, count + 1)
    offsets = points[indices] - points[:, None]
    _, axes = np.linalg.eigh(np.einsum("pki,pkj->pij", offsets, offsets))
    area = math.pi * distances[:, -1] ** 2 / count
    radius = np.sqrt(4.0 * area / (3.0 * math.sqrt(3.0)))
    angles = 2.0 * math.pi / 3.0 * np.arange(3)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    plane = np.moveaxis(axes[:, :, 1:], 2, 1)
    corners = points[:, None] + radius[:, None, None] * np.einsum("ck,pki->pci", circle, plane)
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(points), dtype=np.uint32).reshape(-1, 3))
