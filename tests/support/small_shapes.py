"""Small prepared cabinets made of boxes, for tests of learning."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from articulated import CUBE_FACES
from numpy.typing import NDArray

from kinmo.core.edge_labels import label_edges, sibling_edges
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import motion_type
from kinmo.core.normalisation import Normalisation
from kinmo.core.oriented_box import CORNER_SIGNS
from kinmo.core.shape import Mesh, Part, Shape
from kinmo.core.shape_forms import FlatPart
from kinmo.features.prepared_shape import Boxes, PreparedShape

UP = np.array([0.0, 1.0, 0.0])
BoxSpec = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Centre and half extents of an axis-aligned box."""


def box_mesh(center: NDArray[np.float64], half: NDArray[np.float64]) -> Mesh:
    """The mesh of an axis-aligned box."""
    return Mesh(CORNER_SIGNS * half + center, CUBE_FACES)


def box_surface(center, half, count: int, rng: np.random.Generator) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and normals [count, 3] on the surface of a box, uniform by area."""
    areas = np.repeat([half[1] * half[2], half[0] * half[2], half[0] * half[1]], 2)
    face = rng.choice(6, count, p=areas / areas.sum())
    local = rng.uniform(-1, 1, (count, 3))
    normals = np.zeros((count, 3))
    rows = np.arange(count)
    normals[rows, face // 2] = np.where(face % 2, 1.0, -1.0)
    local[rows, face // 2] = normals[rows, face // 2]
    return local * half + center, normals


def prepare_boxes(shape: Shape, specs: dict[int, BoxSpec], points: int = 128, seed: int = 0) -> PreparedShape:
    """Prepare a shape whose leaves are axis-aligned boxes. `specs` are the boxes by index of the part."""
    rng = np.random.default_rng(seed)
    center, diagonal = shape.center, shape.diagonal
    low, high = np.zeros((len(shape.parts), 3)), np.zeros((len(shape.parts), 3))
    for part, leaves in enumerate(shape.leaves_below):
        spans = [(np.subtract(*specs[leaf]), np.add(*specs[leaf])) for leaf in leaves]
        low[part] = np.min([span[0] for span in spans], axis=0)
        high[part] = np.max([span[1] for span in spans], axis=0)
    low, high = (low - center) / diagonal, (high - center) / diagonal
    boxes = Boxes((low + high) / 2, np.tile(np.eye(3), (len(shape.parts), 1, 1)), (high - low) / 2)
    cloud, normals, areas = [], [], []
    for leaf in shape.leaves:
        middle, half = boxes.centers[leaf], boxes.half_extents[leaf]
        sampled, directions = box_surface(middle, half, points, rng)
        cloud.append(sampled)
        normals.append(directions)
        areas.append(8 * (half[0] * half[1] + half[1] * half[2] + half[0] * half[2]))
    edges = sibling_edges(shape)
    gap = np.maximum(low[edges[:, 0]] - high[edges[:, 1]], low[edges[:, 1]] - high[edges[:, 0]])
    distances = np.linalg.norm(np.maximum(gap, 0.0), axis=1)
    mobility, types, labels, body_boxes = shape.mobility, {}, None, None
    if mobility is not None:
        mobility = Normalisation(center, diagonal).mobility(mobility)
        bodies = mobility.bodies
        low_of = np.array([low[list(body.leaves)].min(axis=0) for body in bodies])
        high_of = np.array([high[list(body.leaves)].max(axis=0) for body in bodies])
        body_boxes = Boxes((low_of + high_of) / 2, np.tile(np.eye(3), (len(bodies), 1, 1)), (high_of - low_of) / 2)
        types = {i: motion_type(body.joint, body_boxes[i], UP) for i, body in mobility.movable()}
        labels = label_edges(shape, mobility, edges, types)
    return PreparedShape(
        id=shape.id, category=shape.category, layout="test", source="test", partnet_id=None, geometry_hash=shape.id,
        up=UP, center=center, diagonal=diagonal, part_ids=tuple(p.id for p in shape.parts),
        part_names=tuple(p.name for p in shape.parts), parents=tuple(-1 if p.parent is None else p.parent for p in shape.parts),
        leaves=shape.leaves, leaf_points=np.array(cloud, np.float32), leaf_normals=np.array(normals, np.float32),
        leaf_areas=np.array(areas), minimum_boxes=boxes, symmetric_boxes=boxes, aligned_boxes=boxes, edges=edges,
        edge_distances=distances, mobility=mobility, body_boxes=body_boxes, body_types=types, edge_labels=labels,
    )  # fmt: skip


def cabinet_shape(seed: int = 0) -> tuple[Shape, dict[int, BoxSpec]]:
    """A random cabinet, and the boxes of its parts by index.

    The body has a top and a plinth. One to three doors (hinged left or right) or drawers have handles.
    """
    rng = np.random.default_rng(seed)
    width, height, depth = rng.uniform(0.4, 0.8, 3)
    parts: list[Part] = []
    specs: dict[int, BoxSpec] = {}

    def add(name: str, parent: int | None, center=None, half=None) -> int:
        index = len(parts)
        mesh = None if center is None else box_mesh(np.array(center), np.array(half))
        parts.append(Part(100 + index, name, parent, (), mesh))
        if parent is not None:
            parts[parent] = replace(parts[parent], children=(*parts[parent].children, index))
        if center is not None:
            specs[index] = (tuple(center), tuple(half))
        return index

    root = add("cabinet", None)
    frame = add("frame", root)
    base = [
        add("top", frame, (0, height, 0), (width, 0.03, depth)),
        add("plinth", frame, (0, -height, 0), (width, 0.03, depth)),
    ]
    bodies: list[Body] = [Body(0, "body", tuple(base))]
    count = int(rng.integers(1, 4))
    for slot in range(count):
        tall = (height - 0.05) / count
        middle = -height + 0.05 + tall * (2 * slot + 1) - 0.02
        is_drawer = rng.random() < 0.5
        group = add("drawer" if is_drawer else "door", root)
        leaves = [
            add("drawer_box", group, (0, middle, depth / 2), (width * 0.9, tall * 0.9, depth / 2))
            if is_drawer
            else add("surface_board", group, (0, middle, depth + 0.03), (width * 0.98, tall * 0.95, 0.02))
        ]
        side = float(rng.choice([-1, 1]))
        handle_x = 0.0 if is_drawer else -side * width * 0.8
        leaves.append(add("handle", group, (handle_x, middle, depth + 0.08), (0.02, 0.08, 0.02)))
        if is_drawer:
            joint = Joint(JointKind.PRISMATIC, np.array([0.0, 0.0, 1.0]), np.zeros(3), 0.0, depth)
        else:
            pivot = np.array([side * width * 0.98, middle, depth + 0.03])
            joint = Joint(JointKind.REVOLUTE, np.array([0.0, 1.0, 0.0]), pivot, 0.0, 1.5)
        bodies.append(Body(slot + 1, parts[group].name, tuple(leaves), 0, joint))
    shape = Shape(f"cabinet-{seed}", "StorageFurniture", tuple(parts), Path(), "test", mobility=Mobility(tuple(bodies)))
    return shape, specs


def cabinet(seed: int = 0, points: int = 128) -> PreparedShape:
    """The prepared shape of `cabinet_shape`."""
    return prepare_boxes(*cabinet_shape(seed), points=points, seed=seed)


def area_by_body(parts: list[FlatPart]) -> dict[int | None, float]:
    """Surface area of the parts of each body."""
    areas: dict[int | None, float] = {}
    for part in parts:
        areas[part.body] = areas.get(part.body, 0.0) + float(part.mesh.face_areas.sum())
    return areas
