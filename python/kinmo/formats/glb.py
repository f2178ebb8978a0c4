"""Binary glTF: one file whose nodes are the parts, y up and +z in front as kinmo has it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.errors import InputError
from kinmo.formats.annotation import UNKNOWN_CATEGORY
from kinmo.formats.field import Field, clean_text
from kinmo.formats.files import LARGEST_MESH, read_bytes
from kinmo.formats.hierarchy import Node, build, check_size
from kinmo.formats.meshes import has_surface
from kinmo.shape import Mesh, Shape

ENDING = ".glb"
MAGIC = b"glTF"


def read_glb(path: Path) -> Shape:
    """Reads a binary glTF file, the nodes of its scene as parts, each where its transforms have it.

    A node that has a mesh and children gets the mesh as one more child. Of nodes above the first one with two children only
    the last is kept. Skins, animations and what lies in other files are not read. Raises InputError for what cannot be used.
    """
    path = Path(path)
    nodes, meshes = _nodes(path)
    hierarchy = build(nodes, meshes)
    name = clean_text(path.stem)
    return Shape(
        id=name,
        category=hierarchy.parts[0].name or UNKNOWN_CATEGORY,
        parts=hierarchy.parts,
        source=path,
        layout="glb",
        partnet_id=name,
        repairs=hierarchy.repairs,
    )


def _nodes(path: Path) -> tuple[list[Node], dict[int, Mesh]]:
    """The nodes in preorder, and the meshes of leaves."""
    import trimesh

    data = read_bytes(path, path.parent, LARGEST_MESH)
    if not data.startswith(MAGIC):
        raise InputError(path, "expected a binary glTF file")
    try:
        scene = trimesh.load_scene(io.BytesIO(data), file_type="glb", process=False)
        children: dict[str, list[str]] = {}
        for child, parent in scene.graph.transforms.parents.items():
            children.setdefault(parent, []).append(child)
        placed = {name: scene.graph[name] for name in scene.graph.nodes_geometry}
        surfaces = {name: _mesh(scene.geometry[geometry], pose) for name, (pose, geometry) in placed.items()}
        base = str(scene.graph.base_frame)
    except Exception as error:  # trimesh raises whatever its parsers do
        raise InputError(path, f"expected a binary glTF file with meshes ({type(error).__name__}: {error})") from None
    whole = Field(path, None)
    nodes: list[Node] = []
    meshes: dict[int, Mesh] = {}
    pending: list[tuple[str, int | None, int, bool]] = [(_top(base, children, surfaces), None, 0, False)]
    while pending:
        name, parent, depth, is_surface = pending.pop()
        check_size(whole, len(nodes), depth)
        own = [] if is_surface else children.get(name, [])
        surface = surfaces.get(name)
        place = len(nodes)
        nodes.append(Node(whole, place, "" if name == base else clean_text(name), parent, not own))
        pending += [(child, place, depth + 1, False) for child in reversed(own)]
        if surface is not None and own:
            pending.append((name, place, depth + 1, True))
        elif surface is not None and has_surface(surface):
            meshes[place] = surface
    return nodes, meshes


def _top(base: str, children: dict[str, list[str]], surfaces: dict[str, Mesh | None]) -> str:
    name = base
    while len(children.get(name, ())) == 1 and surfaces.get(name) is None:
        (name,) = children[name]
    return name


def _mesh(geometry: Any, pose: NDArray[np.float64]) -> Mesh | None:
    """None for what is no surface: points and lines."""
    if getattr(geometry, "faces", None) is None:
        return None
    vertices = np.asarray(geometry.vertices, np.float64) @ pose[:3, :3].T + pose[:3, 3]
    if not np.isfinite(vertices).all():
        raise ValueError("a place that is no number")
    turned = np.asarray(geometry.faces, np.uint32)
    return Mesh(vertices, turned[:, ::-1] if np.linalg.det(pose[:3, :3]) < 0.0 else turned)
