"""DSG-Net's layout: StructureNet's tree JSON with an OBJ file or 1,000 points per leaf, and the errors of a generator.

A generative network displaces and stretches parts, gives some a wrong label, and omits some.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh, join
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Node, SynthObject
from kinmo.synth.writers.text_files import rounded, write_json, write_obj

DISPLACEMENT = 0.012
"""Largest displacement of a part per axis, as a fraction of the object's diagonal."""
STRETCH = 0.04
"""Largest change of a part's extent, as a fraction of it."""
OMITTED_SHARE, MISLABELLED_SHARE = 0.04, 0.03
"""Shares of leaves that are missing, or have the name of another leaf."""
CONTACT = 0.02
"""Largest gap between the boxes of siblings with an ADJ edge, as a fraction of the object's diagonal."""
POINTS = 1000
"""Points per node."""


def write(obj: SynthObject, shape_id: str, folder: Path, draw: Draw) -> None:
    """Write `<category>_hier/<id>.json`, with `<category>_geo/<id>.npz` or `<category>_obj/<id>/<leaf>.obj`."""
    low, high = obj.bounds()
    diagonal = float(np.linalg.norm(high - low))
    _add_generator_errors(obj, draw, diagonal)
    nodes = list(obj.root.walk())
    ids = {node: index for index, node in enumerate(nodes)}
    meshes = {node: join(*(piece for leaf in node.leaves() for piece in leaf.pieces)) for node in nodes}
    category = obj.category.lower()
    hierarchies = folder / f"{category}_hier"
    hierarchies.mkdir()
    write_json(hierarchies / f"{shape_id}.json", _tree(obj.root, ids, meshes, diagonal))
    if draw.chance(0.5):
        points = np.stack([_sample(meshes[node], draw) for node in nodes]).astype(np.float32)
        (folder / f"{category}_geo").mkdir()
        np.savez_compressed(folder / f"{category}_geo" / f"{shape_id}.npz", parts=points)
    else:
        leaves = folder / f"{category}_obj" / shape_id
        leaves.mkdir(parents=True)
        for leaf in obj.root.leaves():
            write_obj(leaves / f"{ids[leaf]}.obj", meshes[leaf])


def _add_generator_errors(obj: SynthObject, draw: Draw, diagonal: float) -> None:
    """Omit, rename, stretch and displace leaves, in place. The object keeps at least two leaves."""
    names = [leaf.name for leaf in obj.root.leaves()]
    for node in list(obj.root.walk()):
        for leaf in [child for child in node.children if not child.children]:
            if draw.chance(OMITTED_SHARE) and len(node.children) > 1 and len(list(obj.root.leaves())) > 2:
                node.children.remove(leaf)
            elif draw.chance(MISLABELLED_SHARE):
                leaf.name = draw.pick(names)
    for leaf in obj.root.leaves():
        mesh = join(*leaf.pieces)
        middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
        factors = 1 + STRETCH * np.array([draw.between(-1, 1) for _ in range(3)])
        shift = DISPLACEMENT * diagonal * np.array([draw.between(-1, 1) for _ in range(3)])
        leaf.pieces = [Mesh(middle + factors * (mesh.vertices - middle) + shift, mesh.faces)]


def _tree(node: Node, ids: dict[Node, int], meshes: dict[Node, Mesh], diagonal: float) -> dict[str, Any]:
    """The node and all below it as StructureNet's JSON."""
    low, high = _bounds(meshes[node])
    box = [*rounded(0.5 * (low + high)), *rounded(high - low), 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    fields: dict[str, Any] = {"id": ids[node], "label": node.name, "box": box}
    if node.children:
        fields["children"] = [_tree(child, ids, meshes, diagonal) for child in node.children]
        fields["edges"] = _edges([_bounds(meshes[child]) for child in node.children], CONTACT * diagonal)
    return fields


def _edges(boxes: list[tuple[NDArray[np.float64], NDArray[np.float64]]], within: float) -> list[dict[str, Any]]:
    """ADJ edges between siblings whose axis-aligned boxes are nearer than `within`."""
    edges = []
    for i, (low, high) in enumerate(boxes):
        for j in range(i):
            gap = np.maximum(np.maximum(low - boxes[j][1], boxes[j][0] - high), 0.0)
            distance = float(np.linalg.norm(gap))
            if distance < within:
                edges.append({"part_a": j, "part_b": i, "type": "ADJ", "params": [], "dist": distance})
    return edges


def _bounds(mesh: Mesh) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)


def _sample(mesh: Mesh, draw: Draw) -> NDArray[np.float64]:
    """Points [POINTS, 3] uniform on the surface."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    rng = draw.generator
    chosen = rng.choice(len(areas), POINTS, p=areas / areas.sum()) if areas.sum() > 0 else rng.integers(len(areas), size=POINTS)
    u, v = rng.random((2, POINTS, 1))
    flipped = u + v > 1
    u, v = np.where(flipped, 1 - u, u), np.where(flipped, 1 - v, v)
    return np.asarray(a[chosen] + u * (b[chosen] - a[chosen]) + v * (c[chosen] - a[chosen]))
