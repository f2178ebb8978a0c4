"""Cutting of a concave surface into about convex pieces, by planes.

`cut_at_faces` takes boards apart: it cuts along the planes of the surface's own faces, and gives no pieces where those do not
get convex. `bisected` is coarse, and works for every surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from kinmo import _core
from kinmo.core.loose_pieces import has_border, pieces_of_faces
from kinmo.core.mesh_splitting import cut_mesh
from kinmo.core.shape import Mesh
from kinmo.robot.convex_hulls import box_of, hull_of, volume_of

F64 = NDArray[np.float64]

CONVEX_TOLERANCE = 0.01
"""Largest distance of a hull from the surface inside it that still counts as convex, in diagonals of the object."""
MIN_THICKNESS = 0.002
"""Least thickness of a piece, in diagonals of the object."""
MAX_BISECTED = 32
"""Most pieces of a surface that is bisected."""
MAX_FACES = 500
"""Most triangles of a surface that is cut at its faces. Boards have few."""
MAX_PIECES = 16
"""Most pieces of a surface that is cut at its faces."""
MAX_PLANES = 12
"""Most planes of faces that a piece may be cut at: those with the largest area."""
MIN_FILL = 0.002
"""Least share of its hull that a solid fills. Sheets with two sides fill nothing."""
MIN_CUT = 0.004
"""Least thickness of what is cut off at a face, in diagonals of the object."""
ON_PLANE = 1e-6
"""Largest distance of a point on a plane, in diagonals of the object."""
SAMPLES = 400
"""Points on a hull that its distance from the surface is measured at."""
QUICK_SAMPLES = 150
"""The same to choose among planes."""
ANGLE_STEP, LEVEL_STEP = 0.005, 0.002
"""Largest differences of the normals, and of the levels in diagonals, of faces in one plane."""


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane.

    Attributes:
        normal: [3], of unit length.
        level: distance from the origin along the normal.
    """

    normal: F64
    level: float

    def heights(self, points: F64) -> F64:
        """Signed distances [P] of points [P, 3]."""
        heights: F64 = points @ self.normal - self.level
        return heights


def concavity(
    piece: Mesh, hull: Mesh, planes: Sequence[Plane] = (), solid: Mesh | None = None, slack: float = 0.0, samples: int = SAMPLES
) -> float:
    """Largest distance of the hull of a piece from its surface, but for the twentieth of the hull that is farthest.

    Args:
        piece: The surface.
        hull: Its convex hull.
        planes: Planes that the piece was cut at. Its surface has holes there.
        solid: The surface before it was cut. Points on the planes that are inside of it count as on the surface.
        slack: Largest distance of a point on a plane.
        samples: Number of points on the hull.
    """
    points = _core.sample_surface(_core.Meshes([hull.vertices], [hull.faces]), samples)[0][0].astype(np.float64)
    distances, _, _ = _core.closest_points(_core.Meshes([piece.vertices], [piece.faces]), [0], points)
    if planes and solid is not None:
        is_cut = np.any([np.abs(plane.heights(points)) <= slack for plane in planes], axis=0)
        cut = np.flatnonzero(is_cut & (distances > slack))
        distances[cut[is_inside(solid, points[cut])]] = 0.0
    return float(np.quantile(distances, 0.95))


def is_inside(mesh: Mesh, points: F64) -> NDArray[np.bool_]:
    """True for each of the points [P, 3] that a surface winds around, even if it has small holes.

    Source: Jacobson et al., Robust Inside-Outside Segmentation using Generalized Winding Numbers, 2013; van Oosterom and
    Strackee, The Solid Angle of a Plane Triangle, 1983.
    """
    a, b, c = np.moveaxis(mesh.triangles[None] - points[:, None, None], 2, 0)
    far_a, far_b, far_c = (np.linalg.norm(corner, axis=2) for corner in (a, b, c))
    volume = np.einsum("pfx,pfx->pf", a, np.cross(b, c))
    products = [np.einsum("pfx,pfx->pf", one, other) * far for one, other, far in ((a, b, far_c), (b, c, far_a), (c, a, far_b))]
    angles = 2.0 * np.arctan2(volume, far_a * far_b * far_c + sum(products))
    inside: NDArray[np.bool_] = np.abs(angles.sum(axis=1)) > 2.0 * np.pi
    return inside


def cut_at_faces(piece: Mesh, diagonal: float) -> list[F64] | None:
    """Corners [P, 3] of convex pieces that a surface of boards is made of.

    It is cut along the plane of a face that frees the largest convex piece, again and again.

    Args:
        piece: The surface.
        diagonal: Diagonal of the whole object.

    Returns:
        The corners of each piece. None if some stay concave, or if the surface has many triangles or
        encloses no solid.
    """
    if len(piece.faces) > MAX_FACES or has_border(piece):
        return None
    whole = hull_of(piece.vertices, MIN_THICKNESS * diagonal)
    if abs(volume_of(piece)) < MIN_FILL * volume_of(whole):
        return None
    tolerance, slack = CONVEX_TOLERANCE * diagonal, ON_PLANE * diagonal
    done: list[F64] = []
    waiting: list[tuple[Mesh, tuple[Plane, ...]]] = [(piece, ())]
    while waiting:
        if len(waiting) + len(done) > MAX_PIECES:
            return None
        widest, planes = waiting.pop()
        plane = _best_plane(widest, planes, piece, diagonal)
        if plane is None:
            return None
        known = (*planes, plane)
        for half in (cut_mesh(widest, plane.normal, plane.level), cut_mesh(widest, -plane.normal, -plane.level)):
            for part in _apart(half) if len(half.faces) else []:
                if np.ptp(plane.heights(part.vertices)) <= slack:
                    continue  # faces in the plane of the cut belong to the other side
                hull = hull_of(part.vertices, MIN_THICKNESS * diagonal)
                if concavity(part, hull, known, piece, slack) <= tolerance:
                    done.append(part.vertices)
                else:
                    waiting.append((part, known))
    return done


def bisected(piece: Mesh, diagonal: float) -> list[F64]:
    """Corners [P, 3] of a piece, bisected across its longest side, and again where the halves are least convex.

    This is coarse and fast. `diagonal` is that of the object.
    """
    done: list[Mesh] = []
    waiting: list[tuple[float, Mesh]] = [(np.inf, piece)]
    while waiting and len(done) + len(waiting) < MAX_BISECTED:
        waiting.sort(key=lambda each: each[0])
        _, widest = waiting.pop()
        center, axes, _ = box_of(widest.vertices)
        for normal in (axes[0], -axes[0]):
            half = cut_mesh(widest, normal, float(normal @ center))
            depth = concavity(half, hull_of(half.vertices, MIN_THICKNESS * diagonal)) if len(half.faces) else 0.0
            if depth > CONVEX_TOLERANCE * diagonal:
                waiting.append((depth, half))
            elif len(half.faces):
                done.append(half)
    return [each.vertices for each in (*done, *(half for _, half in waiting))]


def _best_plane(piece: Mesh, planes: Sequence[Plane], solid: Mesh, diagonal: float) -> Plane | None:
    """The plane of a face that frees the largest convex piece, or else leaves the smallest hulls. None if none cuts."""
    best: tuple[tuple[float, float], Plane] | None = None
    for plane in _face_planes(piece, diagonal):
        heights = plane.heights(piece.vertices)
        if heights.max() < MIN_CUT * diagonal or heights.min() > -MIN_CUT * diagonal:
            continue
        whole = convex = 0.0
        for points in _sides(piece, heights):
            try:
                hull = ConvexHull(points)
            except QhullError:  # a flat side has no volume
                continue
            whole += hull.volume
            surface = Mesh(points, hull.simplices.astype(np.uint32))
            depth = concavity(piece, surface, (*planes, plane), solid, ON_PLANE * diagonal, QUICK_SAMPLES)
            convex += hull.volume if depth <= CONVEX_TOLERANCE * diagonal else 0.0
        cost = (-convex, whole)
        if best is None or cost < best[0]:
            best = cost, plane
    return None if best is None else best[1]


def _face_planes(piece: Mesh, diagonal: float) -> list[Plane]:
    """The planes of a surface's faces that have the largest areas, at most `MAX_PLANES`."""
    triangles = piece.triangles
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    triangles, normals, areas = triangles[areas > 0.0], normals[areas > 0.0], areas[areas > 0.0]
    normals = normals / areas[:, None]
    first = np.argmax(np.abs(normals) > 0.5, axis=1)  # one of them is larger, since they have unit length
    normals *= np.sign(np.take_along_axis(normals, first[:, None], axis=1))
    levels = np.einsum("fx,fx->f", normals, triangles[:, 0])
    keys = np.round(np.column_stack([normals / ANGLE_STEP, levels / (LEVEL_STEP * diagonal)])).astype(np.int64)
    _, group = np.unique(keys, axis=0, return_inverse=True)
    group = group.reshape(-1)
    found = []
    for index in np.argsort(-np.bincount(group, areas), kind="stable")[:MAX_PLANES]:
        own = group == index
        normal = areas[own] @ normals[own]
        normal /= np.linalg.norm(normal)
        corners = triangles[own].mean(axis=1)
        found.append(Plane(normal, float(np.average(corners @ normal, weights=areas[own]))))
    return found


def _sides(piece: Mesh, heights: F64) -> tuple[F64, F64]:
    """The points [P, 3] of a surface on both sides of a plane, and those where its edges cross it, by its vertices' heights."""
    edges = np.concatenate([piece.faces[:, [0, 1]], piece.faces[:, [1, 2]], piece.faces[:, [2, 0]]])
    edges = edges[heights[edges[:, 0]] * heights[edges[:, 1]] < 0.0]
    low, high = heights[edges].T
    share = (low / (low - high))[:, None]
    crossing = piece.vertices[edges[:, 0]] * (1.0 - share) + piece.vertices[edges[:, 1]] * share
    return (
        np.concatenate([piece.vertices[heights >= 0.0], crossing]),
        np.concatenate([piece.vertices[heights <= 0.0], crossing]),
    )


def _apart(mesh: Mesh) -> list[Mesh]:
    """The loose pieces of a surface. Those whose bounding boxes overlap stay together, such as both skins of a wall."""
    pieces = pieces_of_faces(mesh, most=MAX_FACES)
    corners = [mesh.vertices[mesh.faces[pieces == number].ravel()] for number in range(int(pieces.max()) + 1)]
    low, high = (np.array([getattr(points, end)(axis=0) for points in corners]) for end in ("min", "max"))
    _, group = connected_components(np.all((low[:, None] <= high) & (high[:, None] >= low), axis=2))
    return [Mesh(mesh.vertices, mesh.faces[group[pieces] == number]).compact for number in range(int(group.max()) + 1)]
