"""Binary glTF 2.0 (GLB): the nodes of the scene are the parts, with y up and the front at +z."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape, join
from kinmo.core.wording import clean_text
from kinmo.io.readers.gltf_file import FLOAT, INDEX_TYPES, GltfFile
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.part_hierarchy import Node, build_hierarchy, check_depth, check_part_count
from kinmo.io.readers.partnet_annotation import UNKNOWN_CATEGORY
from kinmo.io.readers.reader import Reader

F64 = NDArray[np.float64]

GLB = "glb"
_ENDING = ".glb"
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
"""Codes of primitives that have surfaces."""
MAX_CORNERS = 20_000_000
"""Most vertices and indices of all parts together. A small file may show one mesh many times."""
MAX_NODES = 100_000
"""Most nodes of a scene, including nodes that are no parts, such as bones."""


def read_glb(path: Path) -> Shape:
    """Read a binary glTF file. The nodes of its scene become parts, with their transforms applied.

    The mesh of a node that also has children becomes one more child. Nodes without a mesh at or below them are skipped. So are
    nodes above the first node that has a mesh or several children. The name of the root gives the category.
    """
    path = Path(path)
    nodes, meshes = _Scene(GltfFile(path)).parts()
    hierarchy = build_hierarchy(nodes, meshes)
    return Shape(
        id=clean_text(path.stem),
        category=canonical_category(hierarchy.parts[0].name or UNKNOWN_CATEGORY),
        parts=hierarchy.parts,
        source=path,
        layout=GLB,
        repairs=hierarchy.repairs,
    )


def _id_of_file(path: Path) -> str | None:
    name = clean_text(path.stem)
    return name if path.suffix.lower() == _ENDING and name.strip(".") else None


READER = Reader(GLB, read_glb, lambda path: (path.absolute().parent, [path]), id_of_file=_id_of_file, ending=_ENDING)


@dataclass(frozen=True, eq=False)
class _SceneNode:
    """A node of the scene. `pose` [4, 4] is its transform to the scene, `parent` an index into the list of nodes."""

    field: JsonField
    name: str
    pose: F64
    parent: int | None


class _Scene:
    """The scene of a glTF file."""

    def __init__(self, file: GltfFile) -> None:
        self.file = file
        self.nodes = list(self._scene_nodes())
        self._surfaces: dict[int, Mesh | None] = {}
        self._corners = 0

    def parts(self) -> tuple[list[Node], dict[int, Mesh]]:
        """The nodes that have a mesh at or below them, in preorder, and the placed meshes of the leaves."""
        own = [self._surface(node) for node in self.nodes]
        children: list[list[int]] = [[] for _ in self.nodes]  # those that have a mesh at or below them, the last one first
        for index in reversed(range(len(self.nodes))):
            above = self.nodes[index].parent
            if above is not None and (own[index] is not None or children[index]):
                children[above].append(index)
        top = 0
        while len(children[top]) == 1 and own[top] is None:
            (top,) = children[top]
        parts: list[Node] = []
        meshes: dict[int, Mesh] = {}
        pending: list[tuple[int, int | None, bool]] = [(top, None, False)]  # True: the node's own mesh, beside its children
        while pending:
            index, parent, is_surface = pending.pop()
            node, surface, place = self.nodes[index], own[index], len(parts)
            check_part_count(node.field, place)
            below = [] if is_surface else children[index]
            parts.append(Node(node.field, place, node.name, parent, not below))
            pending += [(child, place, False) for child in below]
            if surface is not None and below:
                pending.append((index, place, True))
            elif surface is not None:
                self._count_corners(len(surface.vertices))
                meshes[place] = _placed(surface, node)
        return parts, meshes

    def _scene_nodes(self) -> Iterator[_SceneNode]:
        """All nodes of the scene in preorder, below one node that stands for the scene."""
        root = self.file.root
        yield _SceneNode(root, "", np.eye(4), None)
        seen: set[int] = set()
        poses = [np.eye(4)]
        pending = [(field, 0, 1) for field in reversed(self._roots())]
        while pending:
            index, parent, depth = pending.pop()
            node = self.file.entry("nodes", index)
            check_depth(node, depth)
            if len(poses) > MAX_NODES:
                raise InputError(root.where, f"more than {MAX_NODES} nodes")
            if index.integer() in seen:
                raise index.fail(f"node {index.integer()} is in two places")
            seen.add(index.integer())
            place = len(poses)
            poses.append(poses[parent] @ _local_pose(node))
            yield _SceneNode(node, node["name"].text(""), poses[place], parent)
            pending += [(child, place, depth + 1) for child in reversed(node["children"].items())]

    def _roots(self) -> list[JsonField]:
        """Indices of the root nodes of the default scene, or of the first scene. Without scenes, of all nodes."""
        root = self.file.root
        if root["scenes"].items():
            scene = root["scene"]
            chosen = root["scenes"].items()[0] if scene.is_absent else self.file.entry("scenes", scene)
            return chosen["nodes"].items()
        nodes = root["nodes"].items()
        below = {child.integer() for node in nodes for child in node["children"].items()}
        return [JsonField(node.where, index, node.path) for index, node in enumerate(nodes) if index not in below]

    def _surface(self, node: _SceneNode) -> Mesh | None:
        """The triangles of a node's mesh in its own frame. None if it has none."""
        if node.parent is None or node.field["mesh"].is_absent:
            return None
        index = node.field["mesh"]
        number = index.integer()
        if number not in self._surfaces:
            pieces = [self._triangles(each) for each in self.file.entry("meshes", index)["primitives"].items()]
            surfaces = [piece for piece in pieces if piece is not None]
            self._surfaces[number] = join(*surfaces) if surfaces else None
        return self._surfaces[number]

    def _triangles(self, primitive: JsonField) -> Mesh | None:
        """The triangles of a primitive. None for points and lines."""
        mode = primitive["mode"].integer(_TRIANGLES)
        position = primitive["attributes"]["POSITION"]
        if mode < _TRIANGLES or position.is_absent:
            return None
        if mode > _FAN:
            raise primitive["mode"].fail(f"expected 0 to 6, got {mode}")
        vertices = self.file.numbers(position, "VEC3", (FLOAT,)).astype(np.float64)
        if not np.isfinite(vertices).all():
            raise position.fail("expected finite numbers")
        indices = primitive["indices"]
        if indices.is_absent:
            order = np.arange(len(vertices), dtype=np.uint32)
        else:
            order = self.file.numbers(indices, "SCALAR", INDEX_TYPES)[:, 0].astype(np.uint32)
            if len(order) and int(order.max()) >= len(vertices):
                raise indices.fail(f"expected indices below {len(vertices)}, got {int(order.max())}")
        self._count_corners(len(vertices) + len(order))
        return Mesh(vertices, _faces(order, mode)).compact

    def _count_corners(self, corners: int) -> None:
        self._corners += corners
        if self._corners > MAX_CORNERS:
            raise InputError(self.file.root.where, f"more than {MAX_CORNERS} corners")


def _local_pose(node: JsonField) -> F64:
    """Transform [4, 4] from a node to its parent."""
    if not node["matrix"].is_absent:
        return np.asarray(node["matrix"].vector(16).reshape(4, 4).T)
    pose = np.eye(4)
    if not node["rotation"].is_absent:
        quaternion = node["rotation"].vector(4)
        if not np.linalg.norm(quaternion) > 0.0:
            raise node["rotation"].fail("expected a quaternion")
        pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    if not node["scale"].is_absent:
        pose[:3, :3] *= node["scale"].vector(3)
    if not node["translation"].is_absent:
        pose[:3, 3] = node["translation"].vector(3)
    return pose


def _placed(surface: Mesh, node: _SceneNode) -> Mesh:
    """The triangles of a node in the scene. Mirrored triangles are flipped, so that they still face outwards."""
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = surface.vertices @ node.pose[:3, :3].T + node.pose[:3, 3]
    if not np.isfinite(vertices).all():
        raise node.field.fail("expected transforms that give finite positions")
    is_mirrored = np.linalg.det(node.pose[:3, :3]) < 0.0
    return Mesh(vertices, surface.faces[:, ::-1] if is_mirrored else surface.faces)


def _faces(order: NDArray[np.uint32], mode: int) -> NDArray[np.uint32]:
    """Faces [F, 3] of a list, strip or fan of triangles."""
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = max(len(order) - 2, 0)
    first = np.full(count, order[0]) if mode == _FAN else order[:count]
    faces = np.column_stack([first, order[1 : count + 1], order[2:]])
    if mode == _STRIP:
        faces[1::2] = faces[1::2, ::-1]
    return faces
