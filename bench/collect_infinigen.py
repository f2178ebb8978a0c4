"""Articulated objects of Infinigen, as URDF folders: objects that kinmo's authors did not model.

Infinigen (Princeton, BSD-3-Clause) builds them in Blender. This script writes the geometry and the joints that its own URDF
exporter derives, with one mesh for each part that the generator labels, and without materials. Objects are closed and z-up.
Only doors have the size of real ones.

kinmo is not needed. Python 3.11 is, with infinigen 1.15 and bpy 4.2. `pip install infinigen` asks for an old scikit-image
without wheels. Installed with `--no-deps`, it works with newer ones.

Usage:
    python bench/collect_infinigen.py --out DIR [--count 15] [--seed 0] [--assets NAME ...]
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_objects import Connection, Piece, UrdfObject, collector_parser, write_urdf_object

ASSETS = {
    "door": ("Door", "y"),
    "toaster": ("Toaster", "y"),
    "dishwasher": ("Dishwasher", "x"),
    "multifridge": ("Refrigerator", "x"),
    "multidoublefridge": ("Refrigerator", "x"),
    "singlefridge": ("Refrigerator", "x"),
    "doublefridge": ("Refrigerator", "x"),
    "lamp": ("Lamp", "x"),
}
"""Category and front by the generator's name of the asset. The front is the side that drawers and buttons are on."""
WITHOUT_PARAMETERS = ("singlefridge", "doublefridge")
"""Assets that are the same for every seed. One object of each is written."""
NO_LIMITS = ((-math.pi, math.pi), (-100.0, 100.0))
"""Limits that the generator's exporter writes where the asset states none."""

WORLD = "world"
"""Name of the generator's empty link above the base."""


def exporter_of_geometry() -> type[Any]:
    """Class of the generator's exporter, changed to keep meshes in `pieces` by file name in place of baking textures."""
    from infinigen.core.sim.exporters.urdf_exporter import URDFBuilder

    class GeometryBuilder(URDFBuilder):
        pieces: dict[str, Piece]

        def _get_mesh(self, attribs: Any, visual_only: bool, image_res: int) -> tuple[Path, list[Path], Any]:
            mesh = self._get_geometry(attribs)
            name = "_".join(sorted(self._get_labels(mesh))) or "part"
            file = f"{name}_{self.asset_freq[name]}"
            self.asset_freq[name] += 1
            vertices, faces = _mesh_arrays(mesh)
            middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))  # the exporter writes it as the origin of the mesh
            self.pieces[file] = Piece(name, vertices - middle, faces)
            return Path(file), [], mesh

        def _get_subsets(self, path: list[Any]) -> Any:
            # without a path the exporter indexes with None, and takes 20 GB for the square of the vertices
            return super()._get_subsets(path) if path else np.ones(len(self.blend_obj.data.vertices), bool)

    return GeometryBuilder


def _mesh_arrays(mesh: Any) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices and triangles of a Blender object."""
    mesh.data.calc_loop_triangles()
    vertices, faces = np.zeros(3 * len(mesh.data.vertices)), np.zeros(3 * len(mesh.data.loop_triangles), np.int64)
    mesh.data.vertices.foreach_get("co", vertices)
    mesh.data.loop_triangles.foreach_get("vertices", faces)
    return vertices.reshape(-1, 3), faces.reshape(-1, 3)


def make_object(name: str, seed: int) -> UrdfObject:
    """Build one object.

    Args:
        name: Name of the asset, a key of `ASSETS`.
        seed: Seed of the generator.

    Returns:
        The object with all joints at zero.
    """
    from infinigen.assets.sim_objects.mapping import OBJECT_CLASS_MAP
    from infinigen.core.sim.exporters.utils import parse_sim_blueprint
    from infinigen.core.util import blender

    blender.clear_scene()
    factory = OBJECT_CLASS_MAP[name](seed)
    spawned = factory.spawn_asset(i=0, exporter="urdf")
    _, root, labels = parse_sim_blueprint(factory.sim_blueprint)
    builder = exporter_of_geometry()(Path())
    builder.pieces = {}
    builder.build(blend_obj=spawned, kinematic_root=root, metadata=labels, visual_only=True)
    category, front = ASSETS[name]
    facts = {
        "category": category, "asset": name, "generator": "infinigen", "version": metadata.version("infinigen"),
        "licence": "BSD-3-Clause", "seed": seed, "up": "z", "front": front,
    }  # fmt: skip
    links = {link.get("name"): _pieces(link, builder.pieces) for link in builder.urdf.findall("link")}
    names = {link: f"{pieces[0].name}_{link}" for link, pieces in links.items() if pieces}  # the generator only numbers links
    named = {names[link]: pieces for link, pieces in links.items() if pieces}
    joints = [_connection(joint, names) for joint in builder.urdf.findall("joint") if joint.find("parent").get("link") != WORLD]
    return UrdfObject(named, joints, facts)


def _numbers(element: Any, key: str) -> list[float]:
    return [float(number) for number in element.get(key).split()]


def _pieces(link: Any, pieces: dict[str, Piece]) -> list[Piece]:
    """The pieces of a `<link>` that have faces, in its frame."""
    placed = []
    for visual in link.findall("visual"):
        piece = pieces[Path(visual.find("geometry/mesh").get("filename")).name]
        if len(piece.faces):
            placed.append(Piece(piece.name, piece.vertices + _numbers(visual.find("origin"), "xyz"), piece.faces))
    return placed


def _connection(joint: Any, names: Mapping[str, str]) -> Connection:
    """The joint of a `<joint>` element between links with new names."""
    name, kind, origin = joint.get("name"), joint.get("type"), _numbers(joint.find("origin"), "xyz")
    parent, child = (names[joint.find(end).get("link")] for end in ("parent", "child"))
    if kind == "fixed":
        return Connection(name, kind, parent, child, origin)
    axis, limit = np.array(_numbers(joint.find("axis"), "xyz")), joint.find("limit")
    unit: Sequence[float] = (axis / np.linalg.norm(axis)).tolist()
    limits = (float(limit.get("lower")), float(limit.get("upper")))
    if not any(np.allclose(limits, ends) for ends in NO_LIMITS):
        return Connection(name, kind, parent, child, origin, axis=unit, limits=limits)
    return Connection(name, "continuous" if kind == "revolute" else kind, parent, child, origin, axis=unit)


def main() -> int:
    """Write the objects, and print the number of each asset."""
    args = collector_parser(__doc__, list(ASSETS)).parse_args()
    for name in args.assets:
        count = 1 if name in WITHOUT_PARAMETERS else args.count
        for seed in range(args.seed, args.seed + count):
            write_urdf_object(args.out / f"{name}-{seed:04d}", make_object(name, seed))
        print(f"{name}: {count} objects", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
