"""The shape of a scene: which of its meshes are parts, and what is guessed about the object."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.categories import known_category
from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS, USUAL_FRONT
from kinmo.core.loose_pieces import is_closed, pieces_of_faces
from kinmo.core.mesh_splitting import merge_small_parts, split_mesh
from kinmo.core.name_words import tell_apart
from kinmo.core.shape import Mesh, Part, Shape, bounds_of, join
from kinmo.core.surface_patches import patches_of_faces
from kinmo.core.wording import clean_text, counted
from kinmo.io.readers.face_labels import read_labels
from kinmo.io.readers.far_parts import far_parts
from kinmo.io.readers.floor_plane import floor_planes
from kinmo.io.readers.part_hierarchy import MAX_PARTS, has_surface
from kinmo.io.readers.scene import Scene, SceneNode, ignored
from kinmo.io.readers.stated_facts import NO_FACTS, StatedFacts
from kinmo.io.readers.upright_names import up_by_names

WITHOUT_UP = ("glb", "obj", "ply", "stl", "mesh_folder")
"""Formats that do not state the up direction, or that other programs often write with another one than theirs."""
LARGEST_IN_METRES = 20.0
"""Diagonal above which a unit of the file is not a metre."""
LARGEST_IN_CENTIMETRES = 500.0
"""Diagonal above which a unit of the file is not a centimetre either, but a millimetre."""
MAX_PATCHES = 150
"""Most patches of an object that is divided at creases."""
HOW_TO_GET_PARTS = (
    "separate the object into one node per part, or give the part of every triangle by --labels faces.npy (the output of a "
    "segmentation tool)"
)


def id_by_ending(endings: tuple[str, ...]) -> Callable[[Path], str | None]:
    """The function `Reader.id_of_file` of a format that is recognised by the ending of the file name."""

    def id_of_file(path: Path) -> str | None:
        name = clean_text(path.stem)
        return name if path.suffix.lower() in endings and name.strip(".") else None

    return id_of_file


def shape_of_scene(scene: Scene, facts: StatedFacts = NO_FACTS) -> Shape:
    """The shape of a scene.

    The nodes with a mesh become parts, in their hierarchy. The mesh of a node that also has children becomes one more child.
    Nodes without a mesh at or below them are skipped. So are nodes above the first node that has a mesh or several children, as
    well as groups without a name that hold one node.
    A floor plane is dropped, and so are parts far from the object. A single mesh is split into its loose pieces. Where parts
    are no more than loose pieces, they are divided at creases, and each becomes a node above its patches. With labels, every
    label is a part. The smallest parts beyond `MAX_PARTS` are merged into others.

    Args:
        scene: A scene of a 3D file.
        facts: What the user states about the object. Everything else is guessed.

    Returns:
        The shape in the frame and units of the file.

    Raises:
        InputError: No mesh has a surface, one closed mesh is all there is, or the labels do not fit.
    """
    scene = _upright(scene)
    repairs = list(scene.repairs)
    meshes = {index: node.mesh for index, node in enumerate(scene.nodes) if node.mesh is not None}
    nodes = scene.nodes
    if facts.labels is not None:
        whole = scene.whole
        labels = read_labels(facts.labels, len(whole.faces), scene.path)
        nodes, meshes = _with_pieces(nodes, 0, _split(whole, labels, repairs))
    flat = [index for index, mesh in meshes.items() if not has_surface(mesh)]
    repairs += [f"{_title(nodes[index], index)} has no surface: skipped" for index in flat]
    meshes = {index: mesh for index, mesh in meshes.items() if index not in set(flat)}
    if not meshes:
        others = ", ".join(ignored(scene.unread))
        raise InputError(scene.path, "no part has geometry" + (f" ({others})" if others else ""))
    if facts.labels is None:
        for index in far_parts(meshes):
            repairs.append(f"{_title(nodes[index], index)} is far from everything else: dropped")
            del meshes[index]
        up = np.array(AXIS_VECTORS[facts.up or scene.up])
        for index in floor_planes(meshes, up):
            repairs.append(f"{_title(nodes[index], index)} is a floor: dropped")
            del meshes[index]
        is_one = len(meshes) == 1
        if is_one:
            ((index, mesh),) = meshes.items()
            own = pieces_of_faces(mesh, most=len(mesh.faces))
            pieces = [piece for piece in _split(mesh, own, repairs) if has_surface(piece)]
            if len(pieces) == 1 and is_closed(pieces[0]):
                raise InputError(scene.path, f"is one closed mesh, so no parts can be told apart: {HOW_TO_GET_PARTS}")
            repairs.append(f"one mesh: split into {counted(len(pieces), 'loose piece')}")
            if len(pieces) > 1:
                nodes, meshes = _with_pieces(nodes, index, pieces)
        if is_one or _are_loose_pieces(nodes, meshes):
            nodes, meshes = _with_patches(nodes, meshes, repairs)
        if len(meshes) == 1:
            raise InputError(scene.path, f"is one surface, so no parts can be told apart: {HOW_TO_GET_PARTS}")
    if len(meshes) > MAX_PARTS:
        keys = np.array(list(meshes))
        whole, own = _joined(meshes)
        own = merge_small_parts(whole, own, MAX_PARTS)
        repairs.append(_merging(len(keys)))
        meshes = dict(zip(keys[np.unique(own)].tolist(), split_mesh(whole, own), strict=True))
    parts, wrappers = _hierarchy(nodes, meshes)
    return _guessed(scene, parts, wrappers, tuple(repairs), facts)


def _upright(scene: Scene) -> Scene:
    """The scene with the up direction that names of parts tell, where files of the format do not state it."""
    if scene.layout not in WITHOUT_UP:
        return scene
    up = up_by_names((node.name, node.mesh) for node in scene.nodes if node.mesh is not None)
    return scene if up in (None, scene.up) else replace(scene, up=up, convention="names of parts")


def _split(mesh: Mesh, labels: NDArray[np.int64], repairs: list[str]) -> list[Mesh]:
    """The parts of a mesh by the label of each face, at most `MAX_PARTS`."""
    if (count := int(labels.max()) + 1) > MAX_PARTS:
        labels = merge_small_parts(mesh, labels, MAX_PARTS)
        repairs.append(_merging(count))
    return split_mesh(mesh, labels)


def _merging(count: int) -> str:
    return f"{count} parts: the {counted(count - MAX_PARTS, 'smallest one')} merged into the nearest larger ones"


def _with_pieces(
    nodes: tuple[SceneNode, ...], index: int, pieces: Iterable[Mesh]
) -> tuple[tuple[SceneNode, ...], dict[int, Mesh]]:
    """Nodes with pieces as new, unnamed nodes below one of them, and the meshes of the new nodes."""
    found = tuple(SceneNode("", index, piece) for piece in pieces)
    meshes = {len(nodes) + place: node.mesh for place, node in enumerate(found) if node.mesh is not None}
    return (*nodes, *found), meshes


def _are_loose_pieces(nodes: tuple[SceneNode, ...], meshes: dict[int, Mesh]) -> bool:
    """True if the meshes are no more than the loose pieces of one mesh, of which there is room for patches.

    False if names tell them apart, if one has several loose pieces, or if two share vertices.
    """
    if len(meshes) >= MAX_PATCHES or tell_apart(nodes[index].name for index in meshes):
        return False
    whole, own = _joined(meshes)
    pieces = pieces_of_faces(whole, most=len(whole.faces))
    return len(np.unique(np.column_stack([own, pieces]), axis=0)) == len(meshes) == int(pieces.max()) + 1


def _joined(meshes: dict[int, Mesh]) -> tuple[Mesh, NDArray[np.int64]]:
    """All meshes as one, and the position [F] of the mesh of every face."""
    return join(*meshes.values()), np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes.values()])


def _with_patches(
    nodes: tuple[SceneNode, ...], meshes: dict[int, Mesh], repairs: list[str]
) -> tuple[tuple[SceneNode, ...], dict[int, Mesh]]:
    """Nodes and meshes with the patches of each loose piece below it."""
    whole, own = _joined(meshes)
    patches = patches_of_faces(whole, own, most=MAX_PATCHES)
    below: dict[int, list[Mesh]] = {}
    _, first = np.unique(patches, return_index=True)
    for mesh, piece in zip(split_mesh(whole, patches), own[first].tolist(), strict=True):
        if has_surface(mesh):
            below.setdefault(piece, []).append(mesh)
    found: dict[int, Mesh] = {}
    for place, index in enumerate(meshes):
        if len(below.get(place, ())) < 2:
            found[index] = meshes[index]
            continue
        nodes, added = _with_pieces(nodes, index, below[place])
        found |= added
    if len(found) > len(meshes):
        repairs.append(f"{counted(len(meshes), 'loose piece')}: divided at creases into {len(found)} patches")
    return nodes, found


def _hierarchy(nodes: tuple[SceneNode, ...], meshes: dict[int, Mesh]) -> tuple[tuple[Part, ...], list[str]]:
    """The parts in preorder, and the names of the first part and the skipped nodes above it, from the inside out."""
    order = _preorder(nodes)
    children: dict[int, list[int]] = {index: [] for index in order}  # those that have a mesh at or below them
    for index in reversed(order):
        above = nodes[index].parent
        if above is not None and (index in meshes or children[index]):
            children[above].insert(0, index)
    keys = _keys(nodes, order, meshes)
    children = {index: sorted(below, key=lambda child: keys[child]) for index, below in children.items()}
    top, wrappers = 0, [nodes[0].name]
    while len(children[top]) == 1 and top not in meshes:
        (top,) = children[top]
        wrappers.insert(0, nodes[top].name)
    rows: list[tuple[str, int | None, Mesh | None]] = []
    pending: list[tuple[int, int | None, bool]] = [(top, None, False)]  # True: the node's own mesh, beside its children
    while pending:
        index, parent, is_surface = pending.pop()
        while not is_surface and index not in meshes and len(children[index]) == 1 and not nodes[index].name:
            (index,) = children[index]  # a group without a name around one node tells nothing
        place, below, mesh = len(rows), [] if is_surface else children[index], meshes.get(index)
        rows.append((nodes[index].name, parent, None if below else mesh))
        pending += [(child, place, False) for child in reversed(below)]
        if below and mesh is not None:
            pending.append((index, place, True))
    inner: list[list[int]] = [[] for _ in rows]
    for place, (_, parent, _) in enumerate(rows):
        if parent is not None:
            inner[parent].append(place)
    parts = (Part(place, *row[:2], tuple(inner[place]), row[2]) for place, row in enumerate(rows))
    return tuple(parts), wrappers


def _keys(nodes: tuple[SceneNode, ...], order: list[int], meshes: dict[int, Mesh]) -> dict[int, tuple[float, ...]]:
    """Sort keys of the nodes by geometry, so that the order in the file does not matter: the largest area first, then by place.

    Relative areas and places are rounded, so that the last digits of the coordinates decide nothing.
    """
    areas, moments = np.zeros(len(nodes)), np.zeros((len(nodes), 3))
    for index, mesh in meshes.items():
        own = mesh.face_areas
        areas[index], moments[index] = own.sum(), own @ mesh.triangles.mean(axis=1)
    for index in reversed(order):
        above = nodes[index].parent
        if above is not None:
            areas[above] += areas[index]
            moments[above] += moments[index]
    low, high = bounds_of(meshes.values())
    places = (moments / np.maximum(areas, np.finfo(np.float64).tiny)[:, None] - low) / np.linalg.norm(high - low)
    rows = np.round(np.column_stack([-areas / areas[0], places]), 5)
    return {index: tuple(rows[index].tolist()) for index in order}


def _preorder(nodes: tuple[SceneNode, ...]) -> list[int]:
    """Indices of the nodes in preorder. New nodes at the end of the list may belong below any other."""
    below: list[list[int]] = [[] for _ in nodes]
    for index, node in enumerate(nodes):
        if node.parent is not None:
            below[node.parent].append(index)
    order, pending = [], [0]
    while pending:
        index = pending.pop()
        order.append(index)
        pending += reversed(below[index])
    return order


def _title(node: SceneNode, index: int) -> str:
    return f"part {index} ({node.name})"


def _guessed(scene: Scene, parts: tuple[Part, ...], wrappers: list[str], repairs: tuple[str, ...], facts: StatedFacts) -> Shape:
    """The shape with the stated facts, and with guesses for the others."""
    name = clean_text(scene.path.stem if scene.path.is_file() else scene.path.absolute().name)
    category = next(filter(None, map(known_category, wrappers)), "")
    unit, source = scene.metres_per_unit, ""
    if unit is None:
        low, high = bounds_of(part.mesh for part in parts if part.mesh is not None)
        size = float(np.linalg.norm(high - low))
        unit = 1.0
        if size > LARGEST_IN_METRES:
            unit = scene.usual_unit or (0.001 if size > LARGEST_IN_CENTIMETRES else 0.01)
        source = " (by its size)"
    front = USUAL_FRONT.get(scene.up)
    guesses = {
        "up": f"up {scene.up if scene.up.startswith('-') else f'+{scene.up}'} ({scene.convention})",
        "metres_per_unit": f"1 unit = {_length(unit)}{source}",
        "category": f"category {category or 'unknown'}",
    }
    shape = Shape(
        id=name,
        category=category,
        parts=parts,
        source=scene.path,
        layout=scene.layout,
        up=AXIS_VECTORS[scene.up],
        front=None if front is None else AXIS_VECTORS[front],
        metres_per_unit=unit,
        guesses=guesses,
        repairs=repairs,
        labels=facts.labels,
    )
    return facts.of(shape)


def _length(metres: float) -> str:
    names = {1.0: "1 m", 0.01: "1 cm", 0.001: "1 mm", 0.0254: "1 inch", 0.3048: "1 foot"}
    return next((name for known, name in names.items() if abs(metres / known - 1.0) < 1e-9), f"{metres:g} m")
