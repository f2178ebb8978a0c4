"""DSG-Net and StructureNet: a tree JSON a shape, geometry beside it.

The tree is {id, label, box, children, edges}. `chair_hier/7.json` finds the geometry of its leaves, in this order, in

1. `chair_obj/7/<leaf id>.obj` (or `chair_objs`), or `7/<leaf id>.obj` beside the tree;
2. the leaf's own field `geo`, a list of points;
3. `chair_geo/7.npz`, or `7.npz` beside the tree: `parts` [N, 1000, 3], by node id, and for negative ids `other_parts` by the
   place of the parent's id in `other_ids`;
4. `chair_dgeo/7.npz`: `LOGR` [N, P, 3] and `S` [N, P, 6], deformation gradients, if cube_meshinfo.mat stands beside that
   folder.

Boxes and edges of the file are not used: kinmo fits its own.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.categories import canonical_category, same_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape
from kinmo.io.readers.array_reader import read_npz
from kinmo.io.readers.deformed_cube import CubeMesh, mesh_of, place_in_box, read_cube_mesh
from kinmo.io.readers.field import Field, clean_text
from kinmo.io.readers.mesh_checks import has_surface
from kinmo.io.readers.obj_reader import read_obj
from kinmo.io.readers.part_hierarchy import Node, build, walk
from kinmo.io.readers.triangulated_points import surface_of_points
from kinmo.io.readers.untrusted_files import inside, read_json

Array = NDArray[np.float64]
_SUFFIX = "_hier"
_CUBE = "cube_meshinfo.mat"
_FEWEST_POINTS = 4


def read_dsg_net(path: Path) -> Shape:
    """Reads the shape of a tree JSON. Raises InputError, naming file and field, for what cannot be used."""
    path = Path(path)
    geometry = _Geometry(path)
    root = Field(path, read_json(path, geometry.dataset))
    nodes = walk(root, "label")
    meshes = {}
    for index, node in enumerate(nodes):
        if node.is_leaf:
            mesh = geometry.of(node, None if node.parent is None else nodes[node.parent].id)
            if has_surface(mesh):
                meshes[index] = mesh
    hierarchy = build(nodes, meshes)
    category, repairs = _category(nodes[0].name, geometry.stem, path)
    return Shape(
        id=shape_id(path),
        category=category,
        parts=hierarchy.parts,
        source=path,
        layout="dsg_net",
        partnet_id=path.stem if path.stem.isdecimal() else None,
        repairs=(*repairs, *hierarchy.repairs),
    )


def shape_id(path: Path) -> str:
    """The id of a tree file: its name, behind the category's where it is a bare number, which other categories have too."""
    stem = _Geometry(path).stem
    return clean_text(f"{stem}-{path.stem}" if stem and path.stem.isdecimal() else path.stem)


def geometry_places(path: Path) -> list[Path]:
    """All files and folders in which the leaves of a tree file may have their geometry, whether they are there or not."""
    return _Geometry(path).places


def _category(label: str, folder: str, path: Path) -> tuple[str, tuple[str, ...]]:
    if not label and not folder:
        raise InputError(path, "expected the category", "label")
    if label and folder and not same_category(label, folder):
        text = f"category {canonical_category(label)} taken from the root part, the folder says {clean_text(folder)}"
        return canonical_category(label), (text,)
    return canonical_category(label or clean_text(folder)), ()


@dataclass(frozen=True)
class _Geometry:
    """Where the leaves of one tree file have their geometry."""

    path: Path

    @cached_property
    def stem(self) -> str:
        """`chair` of `chair_hier`, empty in a folder of another name."""
        name = self.path.absolute().parent.name
        return name[: -len(_SUFFIX)] if name.endswith(_SUFFIX) else ""

    @cached_property
    def dataset(self) -> Path:
        """The folder that geometry may not lead out of."""
        folder = self.path.absolute().parent
        return folder.parent if self.stem else folder

    def _places(self, kind: str, name: str) -> list[Path]:
        beside = [self.path.parent / name]
        return [self.dataset / f"{self.stem}_{kind}" / name, *beside] if self.stem else beside

    @property
    def _mesh_places(self) -> list[Path]:
        return list(dict.fromkeys(self._places("obj", self.path.stem) + self._places("objs", self.path.stem)))

    @property
    def _point_places(self) -> list[Path]:
        return self._places("geo", f"{self.path.stem}.npz")

    @property
    def _gradient_places(self) -> list[Path]:
        return self._places("dgeo", f"{self.path.stem}.npz")[:1] if self.stem else []

    @property
    def places(self) -> list[Path]:
        """Everything that is looked for."""
        return [*self._mesh_places, *self._point_places, *self._gradient_places, self.dataset / _CUBE]

    @cached_property
    def meshes(self) -> Path | None:
        return next((inside(place, self.dataset) for place in self._mesh_places if place.is_dir()), None)

    @cached_property
    def points(self) -> tuple[Path, dict[str, Array]] | None:
        for place in self._point_places:
            if os.path.lexists(place):
                inside(place.parent, self.dataset)
                return place, read_npz(place, self.dataset, ("parts", "other_ids", "other_parts"))
        return None

    @cached_property
    def gradients(self) -> tuple[Path, dict[str, Array], CubeMesh] | None:
        place = next((place for place in self._gradient_places if place.exists()), None)
        if place is None:
            return None
        inside(place.parent, self.dataset)
        cube = self.dataset / _CUBE
        if not cube.exists():
            raise InputError(place, f"deformation gradients need {_CUBE} beside their folder, which is missing")
        return place, read_npz(place, self.dataset, ("LOGR", "S")), read_cube_mesh(cube, self.dataset)

    def of(self, node: Node, parent: int | None) -> Mesh:
        """The mesh of a leaf; one without faces if the file that should have them has none."""
        if self.meshes is not None:
            mesh = read_obj(self.meshes / f"{node.id}.obj", self.dataset)
            return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32)) if mesh is None else mesh
        inline = node.field["geo"]
        if not inline.is_absent:
            return _from_points(_inline_points(inline), inline.where, inline.path)
        if self.points is not None:
            place, arrays = self.points
            return _from_points(_stored_points(arrays, node, parent, place), place, f"parts[{node.id}]")
        if self.gradients is not None:
            return self._decoded(node, *self.gradients)
        raise node.field.fail("has no geometry: expected an OBJ or points for every leaf")

    def _decoded(self, node: Node, place: Path, arrays: dict[str, Array], cube: CubeMesh) -> Mesh:
        count = len(cube.solver)
        for name, width in (("LOGR", 3), ("S", 6)):
            array = arrays.get(name)
            if array is None or array.ndim != 3 or array.shape[1:] != (count, width):
                raise InputError(place, f"expected [N, {count}, {width}] numbers", name)
            if not 0 <= node.id < len(array):
                raise InputError(place, f"there is no part {node.id}", name)
            if not np.all(np.isfinite(array[node.id])):
                raise InputError(place, "expected finite numbers", f"{name}[{node.id}]")
        box = node.field["box"]
        corner = box.vector(12)
        if min(np.linalg.norm(corner[6:9]), np.linalg.norm(corner[9:12])) == 0.0:
            raise box.fail("expected two directions, found zero")
        return mesh_of(cube, place_in_box(cube.decode(arrays["LOGR"][node.id], arrays["S"][node.id]), corner))


def _inline_points(field: Field) -> Array:
    try:
        points = np.array(field.value, np.float64)
    except (ValueError, TypeError, OverflowError):
        raise field.fail("expected points") from None
    if points.size % 3:
        raise field.fail("expected points of 3 numbers")
    rows: Array = points.reshape(-1, 3)
    return rows


def _stored_points(arrays: dict[str, Array], node: Node, parent: int | None, place: Path) -> Array:
    name, index = "parts", node.id
    if node.id < 0:
        name = "other_parts"
        matches = np.flatnonzero(arrays.get("other_ids", np.zeros(0)).ravel() == parent)
        index = int(matches[0]) if len(matches) else -1
    array = arrays.get(name)
    if array is None or array.ndim != 3 or array.shape[2] != 3:
        raise InputError(place, "expected [N, n, 3] numbers", name)
    if not 0 <= index < len(array):
        raise InputError(place, f"there is no part {node.id}", name)
    return np.asarray(array[index], np.float64)


def _from_points(points: Array, where: Path, field: str) -> Mesh:
    if len(points) < _FEWEST_POINTS or not np.all(np.isfinite(points)):
        raise InputError(where, f"expected at least {_FEWEST_POINTS} finite points", field)
    return surface_of_points(points)
