"""COLLADA (DAE): the nodes of the visual scene are the parts. pycollada parses the file (`pip install 'kinmo[formats]'`).

trimesh loses the hierarchy and the names of nodes, and it ignores the up axis and meshes with skins.
"""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.frames import Axis
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.wording import clean_text
from kinmo.io.readers.optional_library import optional_library
from kinmo.io.readers.polygons import triangulate
from kinmo.io.readers.reader import Reader
from kinmo.io.readers.scene import F64, Scene, SceneBuilder, placed
from kinmo.io.readers.scene_shape import id_by_ending, shape_of_scene
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes
from kinmo.io.readers.xml_files import parse_xml

DAE = "dae"
_LOOKS = ("library_images", "library_effects", "library_materials", "bind_material")
"""Elements that say how surfaces look."""
_UP: dict[str, Axis] = {"X_UP": "x", "Y_UP": "y", "Z_UP": "z"}


def read_dae(path: Path, facts: StatedFacts = NO_FACTS) -> Shape:
    """Read a DAE file (see `shape_of_scene`)."""
    return shape_of_scene(read_dae_scene(Path(path)), facts)


def read_dae_scene(path: Path) -> Scene:
    """The default scene of a DAE file. Skins are shown in their bind pose."""
    data = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    collada = optional_library("collada", "formats", path, "is DAE")
    builder = SceneBuilder(path)
    try:
        shown, materials = _without_looks(parse_xml(data, path))
        document = collada.Collada(io.BytesIO(shown), ignore=[collada.common.DaeError])
        if document.scene is None:
            raise InputError(path, "expected a visual scene")
        _add_nodes(builder, collada, document.scene.nodes)
        for _ in range(materials):
            builder.ignore("materials")
        unit, up = document.assetInfo.unitmeter, document.assetInfo.upaxis
    except InputError:
        raise
    except Exception as error:  # pycollada raises many kinds of errors for broken files, and ElementTree one for deep ones
        raise InputError(path, f"expected a readable DAE file ({type(error).__name__}: {error})") from None
    for problem in document.errors:
        builder.ignore(clean_text(str(problem)))
    metres = 1.0 if unit is None or not 0.0 < float(unit) < 1e6 else float(unit)
    return builder.scene(DAE, "DAE", _UP.get(up, "y"), metres)


def _without_looks(root: ET.Element) -> tuple[bytes, int]:
    """The document without looks, and its number of materials. pycollada drops meshes whose material or image is missing."""
    materials = 0
    for above in list(root.iter()):
        for child in list(above):
            name = child.tag.rpartition("}")[2]
            if name in _LOOKS:
                above.remove(child)
                materials += len(child) if name == "library_materials" else 0
    return ET.tostring(root), materials


def _add_nodes(builder: SceneBuilder, collada: Any, roots: list[Any]) -> None:
    """Add all nodes at or below the roots, in the order of the file."""
    pending: list[tuple[Any, int, F64]] = [(node, 0, np.eye(4)) for node in reversed(roots)]
    while pending:
        node, parent, above = pending.pop()
        if not isinstance(node, collada.scene.Node):  # cameras and lights have no children
            continue
        pose = above @ np.asarray(node.matrix, np.float64)
        meshes = [mesh for child in node.children for mesh in _meshes_of(builder, collada, child)]
        place = builder.add(_name(collada, node), parent, join(*meshes) if meshes else None, pose)
        below = [child for child in node.children if isinstance(child, collada.scene.Node)]
        pending += [(child, place, pose) for child in reversed(below)]


def _name(collada: Any, node: Any) -> str:
    """The name of a node. That of an instance is mostly on the node that it shows."""
    while isinstance(node, collada.scene.NodeNode) and not node.xmlnode.get("name"):
        node = node.node
    return node.xmlnode.get("name") or ""


def _meshes_of(builder: SceneBuilder, collada: Any, instance: Any) -> list[Mesh]:
    """The triangles of an instance of a geometry or controller, in the frame of its node."""
    if isinstance(instance, collada.scene.GeometryNode):
        return _triangles(builder, collada, instance.geometry)
    if isinstance(instance, collada.scene.ControllerNode):
        controller = instance.controller
        if isinstance(controller, collada.controller.Skin):
            bind = np.asarray(controller.bind_shape_matrix, np.float64).reshape(4, 4)
            return [placed(mesh, bind, builder.path) for mesh in _triangles(builder, collada, controller.geometry)]
        builder.ignore("morph targets")
        return _triangles(builder, collada, controller.source_geometry)
    return []


def _triangles(builder: SceneBuilder, collada: Any, geometry: Any) -> list[Mesh]:
    found = []
    for primitive in geometry.primitives:
        is_polygons = isinstance(primitive, collada.polylist.Polylist)
        if not is_polygons and not isinstance(primitive, collada.triangleset.TriangleSet):
            builder.ignore("points and lines")
            continue
        if primitive.vertex is None or primitive.vertex_index is None or not len(primitive.vertex_index):
            continue
        corners = np.asarray(primitive.vertex_index, np.int64).ravel()
        vertices = np.asarray(primitive.vertex, np.float64)
        if corners.min() < 0 or corners.max() >= len(vertices):
            raise InputError(builder.path, f"a face names a vertex outside 0..{len(vertices) - 1}")
        sizes = np.asarray(primitive.vcounts if is_polygons else [3] * (len(corners) // 3), np.int64)
        if sizes.min(initial=0) < 0 or sizes.sum() != len(corners):
            raise InputError(builder.path, f"expected polygons of {len(corners)} corners together, got {sizes.sum()}")
        faces, _ = triangulate(vertices, corners, sizes, builder.path)
        found.append(Mesh(vertices, faces.astype(np.uint32)).compact)
    return found


READER = Reader(
    DAE,
    read_dae,
    lambda path: (path.absolute().parent, [path]),
    id_of_file=id_by_ending((".dae",)),
    endings=(".dae",),
    read_stated=read_dae,
    is_bare_mesh=True,
)
