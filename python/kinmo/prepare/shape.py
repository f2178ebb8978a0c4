"""From a shape to what training reads of it."""

from __future__ import annotations

from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.ground_truth import label_edges, motion_type, sibling_edges
from kinmo.joint import MotionType
from kinmo.mobility import Mobility
from kinmo.normalisation import Normalisation, geometry_hash
from kinmo.prepared import Boxes, PreparedShape
from kinmo.shape import Shape

POINTS = 1024


def prepare_shape(shape: Shape, *, points: int = POINTS, seed: int = 0) -> PreparedShape:
    """Points, boxes, distances and labels of `shape`, in the normalised frame.

    `points` samples a leaf are drawn with a generator that depends on `seed` and the shape's id alone. Raises ValueError,
    naming the argument, for meshes that the geometry core refuses.
    """
    frame = Normalisation.of(shape)
    leaf_meshes = [frame.mesh(mesh) for mesh in shape.meshes()]
    meshes = _core.Meshes([mesh.vertices for mesh in leaf_meshes], [mesh.faces for mesh in leaf_meshes])
    place = {leaf: position for position, leaf in enumerate(shape.leaves)}
    groups = [[place[leaf] for leaf in leaves] for leaves in shape.leaves_below]
    samples, normals, _ = _core.sample_surface(meshes, points, seed_of(shape.id, seed))
    edges = sibling_edges(shape)
    labels: dict[str, object] = {}
    if shape.mobility is not None:
        labels = _labels(shape, frame.mobility(shape.mobility), edges, meshes, place)
    return PreparedShape(
        id=shape.id,
        category=shape.category,
        layout=shape.layout,
        source=str(shape.source),
        partnet_id=shape.partnet_id,
        geometry_hash=geometry_hash(leaf_meshes),
        up=np.array(shape.up, np.float64),
        center=frame.center,
        diagonal=frame.diagonal,
        part_ids=tuple(part.id for part in shape.parts),
        part_names=tuple(part.name for part in shape.parts),
        parents=tuple(-1 if part.parent is None else part.parent for part in shape.parts),
        leaves=shape.leaves,
        leaf_points=samples,
        leaf_normals=normals,
        leaf_areas=meshes.areas(),
        minimum_boxes=Boxes(*_core.fit_boxes(meshes, groups)),
        symmetric_boxes=Boxes(*_core.fit_symmetric_boxes(meshes, groups)[:3]),
        aligned_boxes=Boxes(*_core.fit_aligned_boxes(meshes, np.eye(3), groups)),
        edges=edges,
        edge_distances=_edge_distances(meshes, groups, edges),
        **labels,  # type: ignore[arg-type]
    )


def seed_of(shape_id: str, seed: int) -> int:
    """A seed of 63 bits for one shape."""
    return int.from_bytes(blake2b(f"{seed}:{shape_id}".encode(), digest_size=8).digest(), "big") >> 1


def _edge_distances(meshes: _core.Meshes, groups: list[list[int]], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Exact distances [E] of pairs of parts; each pair is measured once."""
    if not len(edges):
        return np.zeros(0)
    pairs, pair_of_edge = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    _, distances, _, _ = _core.part_distances(meshes, groups, pairs.astype(np.uint32))
    return np.asarray(distances[pair_of_edge.ravel()])


def _labels(
    shape: Shape, mobility: Mobility, edges: NDArray[np.int64], meshes: _core.Meshes, place: dict[int, int]
) -> dict[str, object]:
    """The fields of `PreparedShape` that an annotated shape has beside the others."""
    groups = [[place[leaf] for leaf in body.leaves] for body in mobility.bodies]
    boxes = Boxes(*_core.fit_symmetric_boxes(meshes, groups)[:3])
    up = np.array(shape.up, np.float64)
    types: dict[int, MotionType] = {
        index: motion_type(body.joint, boxes[index], up) for index, body in mobility.movable() if body.joint is not None
    }
    return {
        "mobility": mobility,
        "body_boxes": boxes,
        "body_types": types,
        "edge_labels": label_edges(shape, mobility, edges, types),
    }
