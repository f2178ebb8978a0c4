"""Preparation of shapes: from meshes to the samples, boxes, distances, features and labels of a `PreparedShape`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.edge_labels import EdgeLabels, label_edges, sibling_edges
from kinmo.core.motion_types import MotionType, motion_type
from kinmo.core.normalisation import Normalisation, geometry_hash
from kinmo.core.shape import Shape
from kinmo.features.candidate_features import compute_candidate_features
from kinmo.features.contact_graph import compute_contact_graph
from kinmo.features.prepared_shape import Boxes, PreparedShape
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]
POINTS_PER_LEAF = 1024
"""Surface samples per leaf (paper, section 3.2)."""


def prepare_shape(shape: Shape, *, points: int = POINTS_PER_LEAF, seed: int = 0) -> PreparedShape:
    """Compute samples, boxes, distances, candidate features and labels of a shape, in the normalised frame.

    Args:
        shape: A shape in the frame and lengths of its file.
        points: Surface samples per leaf.
        seed: Seed of the samples. Those of a leaf depend on it and on the leaf's mesh alone.

    Raises:
        ValueError: The geometry core rejects the meshes; the message names the argument.
    """
    frame = Normalisation.of(shape)
    leaf_meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    meshes = _core.Meshes([mesh.vertices for mesh in leaf_meshes], [mesh.faces for mesh in leaf_meshes])
    position = {leaf: place for place, leaf in enumerate(shape.leaves)}
    parts = [tuple(position[leaf] for leaf in leaves) for leaves in shape.leaves_below]
    mobility = None if shape.mobility is None else frame.mobility(shape.mobility)
    bodies = [] if mobility is None else [tuple(sorted(position[leaf] for leaf in body.leaves)) for body in mobility.bodies]
    symmetric = _fit_boxes(lambda groups: _core.fit_symmetric_boxes(meshes, groups)[:3], parts + bodies)
    body_boxes = symmetric.subset(slice(len(parts), None))
    samples, normals, _ = _core.sample_surface(meshes, points, seed)
    edges = sibling_edges(shape)
    up, areas = np.array(shape.up, np.float64), meshes.areas()
    minimum_boxes = _fit_boxes(lambda groups: _core.fit_boxes(meshes, groups), parts)
    candidate_features: dict[str, NDArray[np.generic]] = {}
    geometry = ShapeGeometry.of(meshes, samples, normals, areas, up)
    if groups := tuple(dict.fromkeys((*parts[1:], *bodies))):
        candidate_features = compute_candidate_features(geometry, groups).arrays()
    body_types: dict[int, MotionType] = {}
    edge_labels: EdgeLabels | None = None
    if mobility is not None:
        body_types = {i: motion_type(body.joint, body_boxes[i], up) for i, body in mobility.movable() if body.joint is not None}
        edge_labels = label_edges(shape, mobility, edges, body_types)
    return PreparedShape(
        id=shape.id,
        category=shape.category,
        layout=shape.layout,
        source=str(shape.source),
        partnet_id=shape.partnet_id,
        geometry_hash=geometry_hash(leaf_meshes),
        up=up,
        center=frame.center,
        diagonal=frame.diagonal,
        part_ids=tuple(part.id for part in shape.parts),
        part_names=tuple(part.name for part in shape.parts),
        parents=tuple(-1 if part.parent is None else part.parent for part in shape.parts),
        leaves=shape.leaves,
        leaf_points=samples,
        leaf_normals=normals,
        leaf_areas=areas,
        minimum_boxes=minimum_boxes,
        symmetric_boxes=symmetric.subset(slice(len(parts))),
        aligned_boxes=_fit_boxes(lambda groups: _core.fit_aligned_boxes(meshes, np.eye(3), groups), parts),
        edges=edges,
        edge_distances=_edge_distances(meshes, parts, edges),
        mobility=mobility,
        body_boxes=None if mobility is None else body_boxes,
        body_types=body_types,
        edge_labels=edge_labels,
        candidate_features=candidate_features,
        contact_graph=compute_contact_graph(geometry).arrays(),
    )


def _fit_boxes(fit: Callable[[list[list[int]]], tuple[F64, ...]], groups: Sequence[tuple[int, ...]]) -> Boxes:
    """Boxes of all groups of leaves; equal groups, such as a body and the part it consists of, are fitted once."""
    position = {group: index for index, group in enumerate(dict.fromkeys(groups))}
    return Boxes(*fit([list(group) for group in position])).subset([position[group] for group in groups])


def _edge_distances(meshes: _core.Meshes, parts: Sequence[tuple[int, ...]], edges: NDArray[np.int64]) -> F64:
    """Exact distances [E] of pairs of parts; each pair is measured once."""
    if not len(edges):
        return np.zeros(0)
    pairs, pair_of_edge = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    _, distances, _, _ = _core.part_distances(meshes, list(map(list, parts)), pairs.astype(np.uint32))
    return np.asarray(distances[pair_of_edge.ravel()])
