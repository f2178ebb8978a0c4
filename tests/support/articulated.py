"""Hypothesis strategies for joints, and small articulated shapes made of boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinmo.core.edge_labels import sibling_edges
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.motion_types import motion_type
from kinmo.core.normalisation import Normalisation
from kinmo.core.shape import Mesh, Part, Shape
from kinmo.features.prepared_shape import Boxes, PreparedShape

CUBE_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ],
    np.uint32,
)  # fmt: skip
"""Triangles of a cube whose corners are in the order of `kinmo.core.oriented_box.CORNER_SIGNS`."""

coordinates = st.floats(-2.0, 2.0)
vectors = st.tuples(coordinates, coordinates, coordinates).map(np.array)
rotations = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda v: Rotation.from_rotvec(v).as_matrix())
directions = rotations.map(lambda r: r[:, 0])


@st.composite
def joints(draw, kinds=tuple(JointKind), limited=None):
    """Joints of some kinds. `limited` tells if they have limits (None: some have)."""
    kind = draw(st.sampled_from(kinds))
    joint = Joint(kind, draw(directions), draw(vectors))
    if draw(st.booleans()) if limited is None else limited:
        lower = draw(st.floats(-1.5, 1.0))
        joint = Joint(kind, joint.direction, joint.pivot, lower, lower + draw(st.floats(0.01, 2.0)))
    return joint


def box_mesh(low, high) -> Mesh:
    """The mesh of an axis-aligned box between two corners."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    return Mesh(np.asarray(low) + corners * (np.asarray(high) - np.asarray(low)), CUBE_FACES.copy())


def shape_of_boxes(
    boxes, bodies, *, shape_id="7", category="Cabinet", names=None, up=(0.0, 1.0, 0.0), junk=frozenset()
) -> Shape:
    """A shape of one root with a box (low, high) per leaf. `bodies` own leaves by the index of the part (1, 2, ...)."""
    count = len(boxes)
    leaves = [Part(i + 1, (names or {}).get(i + 1, f"part {i}"), 0, (), box_mesh(*box)) for i, box in enumerate(boxes)]
    root = Part(0, "object", None, tuple(range(1, count + 1)))
    mobility = Mobility(tuple(bodies), junk)
    return Shape(shape_id, category, (root, *leaves), Path("nowhere"), "test", up, mobility)


@st.composite
def articulated_shapes(draw, max_bodies=6, ups=((0.0, 1.0, 0.0),)):
    """A tree of 2 to `max_bodies` boxes. Some bodies are fixed to their parents. There may be several roots."""
    count = draw(st.integers(2, max_bodies))
    boxes, bodies = [], []
    for index in range(count):
        low = draw(vectors)
        boxes.append((low, low + np.array(draw(st.tuples(*[st.floats(0.05, 1.0)] * 3)))))
        parent = draw(st.integers(0, index - 1)) if index else None
        is_fixed = draw(st.integers(0, 4)) == 0
        joint = None if parent is None or is_fixed else draw(joints())
        bodies.append(
            Body(index, draw(st.sampled_from(["door", "a/b <&>", "", "door", "Tür", "扉"])), (index + 1,), parent, joint)
        )
    return shape_of_boxes(boxes, bodies, up=draw(st.sampled_from(ups)))


def prepared_from(shape: Shape, points: int = 64) -> PreparedShape:
    """The prepared shape in the normalised frame. All kinds of boxes are the axis-aligned bounding boxes."""
    normalise = Normalisation.of(shape)
    rng = np.random.default_rng(0)
    meshes = [normalise.mesh(mesh) for mesh in shape.meshes()]
    soups = [mesh.triangles for mesh in meshes]
    areas = [0.5 * np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1) for t in soups]
    samples, normals = [], []
    for soup, area in zip(soups, areas, strict=True):
        chosen = soup[rng.choice(len(soup), points, p=area / area.sum())]
        weights = rng.dirichlet(np.ones(3), points)
        samples.append(np.einsum("nk,nkd->nd", weights, chosen))
        normals.append(np.cross(chosen[:, 1] - chosen[:, 0], chosen[:, 2] - chosen[:, 0]))
    edges = sibling_edges(shape)
    mobility = None if shape.mobility is None else normalise.mobility(shape.mobility)
    mesh_of = dict(zip(shape.leaves, meshes, strict=True))

    def boxes(groups) -> Boxes:
        corners = [np.concatenate([mesh_of[leaf].vertices for leaf in leaves]) for leaves in groups]
        low, high = np.array([c.min(axis=0) for c in corners]), np.array([c.max(axis=0) for c in corners])
        return Boxes(0.5 * (low + high), np.broadcast_to(np.eye(3), (len(corners), 3, 3)).copy(), 0.5 * (high - low))

    part_boxes = boxes(shape.leaves_below)
    body_boxes = None if mobility is None else boxes([body.leaves for body in mobility.bodies])
    up = np.array(shape.up)
    types = {i: motion_type(body.joint, body_boxes[i], up) for i, body in mobility.movable()} if mobility else {}
    return PreparedShape(
        id=shape.id,
        category=shape.category,
        layout=shape.layout,
        source=str(shape.source),
        partnet_id=None,
        geometry_hash="",
        up=up,
        center=normalise.center,
        diagonal=normalise.diagonal,
        part_ids=tuple(part.id for part in shape.parts),
        part_names=tuple(part.name for part in shape.parts),
        parents=tuple(-1 if part.parent is None else part.parent for part in shape.parts),
        leaves=shape.leaves,
        leaf_points=np.array(samples, np.float32),
        leaf_normals=np.array([n / np.linalg.norm(n, axis=1, keepdims=True) for n in normals], np.float32),
        leaf_areas=np.array([area.sum() for area in areas]),
        minimum_boxes=part_boxes,
        symmetric_boxes=part_boxes,
        aligned_boxes=part_boxes,
        edges=edges,
        edge_distances=np.zeros(len(edges)),
        mobility=mobility,
        body_boxes=body_boxes,
        body_types=types,
    )
