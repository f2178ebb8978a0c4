"""Binary glTF 2.0 (Khronos Group): one file whose nodes are the parts, y up and +z in front as kinmo has it."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.core.categories import canonical_category
from kinmo.core.errors import InputError
from kinmo.core.shape import Mesh, Shape, join
from kinmo.io.readers.field import Field, clean_text
from kinmo.io.readers.mesh_checks import has_surface
from kinmo.io.readers.part_hierarchy import Node, build, check_depth, check_number
from kinmo.io.readers.partnet_annotation import UNKNOWN_CATEGORY
from kinmo.io.readers.untrusted_files import LARGEST_JSON, LARGEST_MESH, read_bytes

F64 = NDArray[np.float64]

ENDING = ".glb"
_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_LOOKS_ALONE = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "EXT_lights_", "MSFT_texture_", "KHR_xmp_")
"""What begins the names of extensions that change nothing about where surfaces lie."""
_NUMBERS: dict[int, np.dtype[Any]] = {
    5121: np.dtype("<u1"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
_FLOAT = 5126
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_MOST_CORNERS = 20_000_000
"""Read and placed, of all parts together: a small file may show one mesh many times."""
_MOST_NODES = 100_000
"""Of a scene, those that are no parts included: bones, say."""


def read_glb(path: Path) -> Shape:
    """Reads a binary glTF file, the nodes of its scene as parts, each where its transforms have it.

    A node that has a mesh and children with meshes gets its own as one more child. Nodes without a mesh at or below them are
    passed over, as are those above the first one that has a mesh or several children. Raises InputError, naming file and field,
    for what cannot be used.
    """
    path = Path(path)
    nodes, meshes = _Scene(path).parts()
    hierarchy = build(nodes, meshes)
    return Shape(
        id=clean_text(path.stem),
        category=canonical_category(hierarchy.parts[0].name or UNKNOWN_CATEGORY),
        parts=hierarchy.parts,
        source=path,
        layout="glb",
        repairs=hierarchy.repairs,
    )


@dataclass(frozen=True, eq=False)
class _Item:
    """A node in its place: `pose` [4, 4] in the scene."""

    field: Field
    name: str
    pose: F64
    parent: int | None


class _Scene:
    """The scene of a file."""

    def __init__(self, path: Path) -> None:
        self.root, self.binary = _chunks(path)
        for needed in self.root["extensionsRequired"].items():
            if not needed.text().startswith(_LOOKS_ALONE):
                raise needed.fail(f"expected a file that can be read without {needed.text()}: export it without")
        self._lists: dict[str, list[Field]] = {}
        self._surfaces: dict[int, Mesh | None] = {}
        self._corners = 0

    def parts(self) -> tuple[list[Node], dict[int, Mesh]]:
        """The nodes that have a mesh at or below them, in preorder, and the meshes of leaves."""
        items = list(self._items())
        own = [self._surface(item) for item in items]
        is_kept = [surface is not None for surface in own]
        for index in reversed(range(len(items))):
            parent = items[index].parent
            if parent is not None and is_kept[index]:
                is_kept[parent] = True
        children: list[list[int]] = [[] for _ in items]
        for index, item in enumerate(items):
            if item.parent is not None and is_kept[index]:
                children[item.parent].append(index)
        top = 0
        while len(children[top]) == 1 and own[top] is None:
            (top,) = children[top]
        nodes: list[Node] = []
        meshes: dict[int, Mesh] = {}
        pending: list[tuple[int, int | None, bool]] = [(top, None, False)]
        while pending:
            index, parent, is_surface = pending.pop()
            item, surface, place = items[index], own[index], len(nodes)
            check_number(item.field, place)
            below = [] if is_surface else children[index]
            nodes.append(Node(item.field, place, item.name, parent, not below))
            pending += [(child, place, False) for child in reversed(below)]
            if surface is not None and below:
                pending.append((index, place, True))
            elif surface is not None:
                self._take_in(len(surface.vertices))
                mesh = _placed(surface, item)
                if has_surface(mesh):
                    meshes[place] = mesh
        return nodes, meshes

    def _items(self) -> Iterator[_Item]:
        """All nodes of the scene below one that holds them together, in preorder."""
        yield _Item(self.root, "", np.eye(4), None)
        seen: set[int] = set()
        poses = [np.eye(4)]
        pending = [(field, 0, 1) for field in reversed(self._roots)]
        while pending:
            index, parent, depth = pending.pop()
            node = self._entry("nodes", index)
            check_depth(node, depth)
            if len(poses) > _MOST_NODES:
                raise InputError(self.root.where, f"more than {_MOST_NODES} nodes")
            if index.integer() in seen:
                raise index.fail(f"node {index.integer()} is in two places")
            seen.add(index.integer())
            place = len(poses)
            poses.append(poses[parent] @ _local(node))
            yield _Item(node, node["name"].text(""), poses[place], parent)
            pending += [(child, place, depth + 1) for child in reversed(node["children"].items())]

    @property
    def _roots(self) -> list[Field]:
        """Of the scene to show, else of the first; of all nodes where there is none."""
        if self.root["scenes"].items():
            scene = self.root["scene"]
            chosen = self.root["scenes"].items()[0] if scene.is_absent else self._entry("scenes", scene)
            return chosen["nodes"].items()
        nodes = self.root["nodes"].items()
        below = {child.integer() for node in nodes for child in node["children"].items()}
        return [Field(node.where, index, node.path) for index, node in enumerate(nodes) if index not in below]

    def _entry(self, name: str, index: Field) -> Field:
        """What a field counts in one of the lists of the file."""
        if name not in self._lists:
            self._lists[name] = self.root[name].items()
        entries = self._lists[name]
        if not 0 <= index.integer() < len(entries):
            raise index.fail(f"expected one of the {len(entries)} {name}, got {index.integer()}")
        return entries[index.integer()]

    def _surface(self, item: _Item) -> Mesh | None:
        """The triangles of a node's mesh, before it is placed; None if it has none."""
        index = item.field["mesh"] if item.parent is not None else Field(item.field.where, None)
        if index.is_absent:
            return None
        number = index.integer()
        if number not in self._surfaces:
            pieces = [self._piece(each) for each in self._entry("meshes", index)["primitives"].items()]
            surfaces = [piece for piece in pieces if piece is not None]
            self._surfaces[number] = join(*surfaces) if surfaces else None
        return self._surfaces[number]

    def _take_in(self, corners: int) -> None:
        self._corners += corners
        if self._corners > _MOST_CORNERS:
            raise InputError(self.root.where, f"more than {_MOST_CORNERS} corners")

    def _piece(self, primitive: Field) -> Mesh | None:
        """None for points and lines."""
        mode = primitive["mode"].integer() if not primitive["mode"].is_absent else _TRIANGLES
        position = primitive["attributes"]["POSITION"]
        if mode < _TRIANGLES or position.is_absent:
            return None
        vertices = self._numbers(position, "VEC3", (_FLOAT,)).astype(np.float64)
        if not np.isfinite(vertices).all():
            raise position.fail("expected finite numbers")
        indices = primitive["indices"]
        if indices.is_absent:
            order = np.arange(len(vertices), dtype=np.uint32)
        else:
            order = self._numbers(indices, "SCALAR", tuple(kind for kind in _NUMBERS if kind != _FLOAT))[:, 0].astype(np.uint32)
            if len(order) and int(order.max()) >= len(vertices):
                raise indices.fail(f"expected indices below {len(vertices)}, got {int(order.max())}")
        self._take_in(len(vertices) + len(order))
        faces = _triangles(order, mode)
        if faces is None:
            raise primitive["mode"].fail(f"expected 0 to 6, got {mode}")
        return Mesh(vertices, faces).compact

    def _numbers(self, index: Field, kind: str, allowed: tuple[int, ...]) -> NDArray[Any]:
        """The numbers [count, width] of an accessor, seen in the file's bytes."""
        accessor = self._entry("accessors", index)
        component = accessor["componentType"]
        if component.integer() not in allowed:
            names = ", ".join(_NUMBERS[each].name for each in allowed)
            raise component.fail(f"expected {names}, got type {component.integer()}: export without quantization")
        if accessor["type"].text() != kind:
            raise accessor["type"].fail(f"expected {kind}")
        if not accessor["sparse"].is_absent or accessor["bufferView"].is_absent:
            raise accessor.fail("expected all numbers in a bufferView: export without sparse accessors and compression")
        view = self._entry("bufferViews", accessor["bufferView"])
        buffer = self._entry("buffers", view["buffer"])
        if view["buffer"].integer() != 0 or not buffer["uri"].is_absent:
            raise view["buffer"].fail("expected what is in the file itself")
        number = _NUMBERS[component.integer()]
        size = number.itemsize * _WIDTHS[kind]
        begin = _count(view["byteOffset"]) + _count(accessor["byteOffset"])
        end = min(_count(view["byteOffset"]) + _count(view["byteLength"]), len(self.binary))
        count, stride = _count(accessor["count"]), _count(view["byteStride"]) or size
        if count == 0 or stride < size or begin + (count - 1) * stride + size > end:
            raise accessor["count"].fail(f"expected as many as there are bytes of, got {count}")
        found: NDArray[Any] = np.ndarray((count, _WIDTHS[kind]), number, self.binary, begin, (stride, number.itemsize))
        return found


def _chunks(path: Path) -> tuple[Field, bytes]:
    """The JSON of a file, and what binary data it has."""
    data = read_bytes(path, path.parent, LARGEST_MESH)
    if len(data) < _HEADER.size or not data.startswith(b"glTF"):
        raise InputError(path, "expected a binary glTF file")
    _, version, length = _HEADER.unpack_from(data)
    if version != 2:
        raise InputError(path, f"expected version 2 of glTF, got {version}")
    if length != len(data):
        raise InputError(path, f"expected {length} bytes, as its header says, got {len(data)}")
    chunks: dict[bytes, bytes] = {}
    begin = _HEADER.size
    while begin + _CHUNK.size <= length:
        size, kind = _CHUNK.unpack_from(data, begin)
        begin += _CHUNK.size
        if begin + size > length:
            raise InputError(path, "a chunk is longer than the file")
        chunks.setdefault(kind, data[begin : begin + size])
        begin += size
    if len(chunks.get(b"JSON", b"")) > LARGEST_JSON:
        raise InputError(path, f"its JSON is larger than {LARGEST_JSON >> 20} MiB")
    try:
        value = json.loads(chunks[b"JSON"].decode("utf-8"))
    except RecursionError:
        raise InputError(path, "nested too deeply") from None
    except (KeyError, ValueError) as error:
        raise InputError(path, f"expected a chunk of JSON ({error})") from None
    return Field(path, value), chunks.get(b"BIN\0", b"")


def _local(node: Field) -> F64:
    """Where a node is in its parent, [4, 4]."""
    if not node["matrix"].is_absent:
        return np.asarray(node["matrix"].vector(16).reshape(4, 4).T)
    pose = np.eye(4)
    if not node["rotation"].is_absent:
        turn = node["rotation"].vector(4)
        if not np.linalg.norm(turn) > 0.0:
            raise node["rotation"].fail("expected a quaternion")
        pose[:3, :3] = Rotation.from_quat(turn).as_matrix()
    if not node["scale"].is_absent:
        pose[:3, :3] *= node["scale"].vector(3)
    if not node["translation"].is_absent:
        pose[:3, 3] = node["translation"].vector(3)
    return pose


def _placed(surface: Mesh, item: _Item) -> Mesh:
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = surface.vertices @ item.pose[:3, :3].T + item.pose[:3, 3]
    if not np.isfinite(vertices).all():
        raise item.field.fail("expected transforms that leave places finite")
    is_mirrored = np.linalg.det(item.pose[:3, :3]) < 0.0
    return Mesh(vertices, surface.faces[:, ::-1] if is_mirrored else surface.faces)


def _triangles(order: NDArray[np.uint32], mode: int) -> NDArray[np.uint32] | None:
    """Faces [F, 3]; None for an unknown mode."""
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = max(len(order) - 2, 0)
    if mode == _FAN:
        return np.column_stack([np.full(count, order[0]), order[1 : count + 1], order[2:]])
    if mode != _STRIP:
        return None
    faces = np.column_stack([order[:count], order[1 : count + 1], order[2:]])
    faces[1::2] = faces[1::2, ::-1]
    return faces


def _count(field: Field) -> int:
    """A number of things or bytes; 0 where it is not said."""
    value = 0 if field.is_absent else field.integer()
    if value < 0:
        raise field.fail("expected a number that is not below 0")
    return value
