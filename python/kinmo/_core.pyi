"""Geometry of articulated objects, in Rust.

Conventions of all functions:

- Arrays are NumPy arrays of the stated dtype, in any memory layout. Results are new arrays in C order.
- Lengths are in the units of the input, angles in radians. Results are in the frame of the input.
- Work runs without the GIL on all threads. The variable RAYON_NUM_THREADS limits their number.
- Results do not depend on the number of threads. A `seed` is an integer from 0 to 2**64 - 1.
- Ctrl-C stops the work within about 0.05 seconds, or after the current item of the batch if that takes longer.
- A process that was forked from one that has used this module works with one thread.

Errors of all functions:

- ValueError: An argument has a wrong shape or value. The message begins with the name of the argument. Unless stated otherwise,
  numbers must be finite and at most 1e60 in size, and counts at least 1. Lengths below 1e-100 may count as zero.
- TypeError: An argument has another type or dtype.
- MemoryError: The result does not fit into memory.

P is the number of meshes and G the number of groups. A group is a list of mesh indices that count as one part. It may not be
empty. `groups=None` makes every mesh a group of its own, so that G = P.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
F32 = NDArray[np.float32]
U32 = NDArray[np.uint32]

Groups = Sequence[Sequence[int]] | None

__version__: str

class Meshes:
    """Triangle meshes of the parts of one shape, checked once and copied.

    Faces may be degenerate, repeated or inverted. Vertices that no face uses are dropped.

    Args:
        vertices: Vertices of each mesh, float64 [V, 3].
        faces: Vertex indices of the faces of each mesh, uint32 [F, 3].

    Raises:
        ValueError: The two lists differ in length, a mesh has no face, or an index or coordinate is out of range. The message
            begins with the list and the number of the mesh, such as `faces[3]`.
    """

    def __init__(self, vertices: Sequence[F64], faces: Sequence[U32]) -> None: ...
    def __len__(self) -> int: ...
    def areas(self) -> F64:
        """Surface area [P] of every mesh."""

def sample_surface(meshes: Meshes, count: int, seed: int = 0, *, blue_noise: bool = False) -> tuple[F32, F32, U32]:
    """Sample points on every mesh, uniformly by area.

    The points of a mesh are in random order, so the first n of them are uniform too. They do not depend on the other meshes.
    The draws are stratified: each is from another piece of the surface, and all pieces have the same area. A mesh without
    area is sampled along its edges, by length. A mesh without length is sampled at its vertices.

    Args:
        meshes: The meshes.
        count: Number of points on each mesh: at most 1e7, or 1e5 with `blue_noise`, and at most 1e8 on all meshes together.
        seed: Seed of the draws.
        blue_noise: Space the points evenly, by weighted sample elimination.

    Returns:
        Points [P, count, 3], unit normals [P, count, 3] and face indices [P, count]. Without area, a normal is some unit
        vector perpendicular to the edge.

    Raises:
        ValueError: A coordinate does not fit float32, or `count` is out of range.

    Source: Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, 2015.
    """

def fit_boxes(meshes: Meshes, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Fit the box of minimum volume to every group.

    Among boxes whose volumes agree to 1e-5, the one most aligned with the coordinate axes wins. A flat or line-like part has
    half extents of about zero in the missing directions.

    Args:
        meshes: The meshes.
        groups: Meshes of each part.

    Returns:
        Centers [G, 3], axes [G, 3, 3] and half extents [G, 3]. The rows of `axes` are unit vectors, right-handed, by descending
        extent. The largest component of each of the first two is positive.
    """

def fit_symmetric_boxes(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 100, tolerance: float = 1e-4
) -> tuple[F64, F64, F64, NDArray[np.uint8]]:
    """Fit a box that follows the symmetries of the part to every group (Fish et al. 2014).

    Candidates are the box of minimum volume and the best boxes along facet normals of the convex hull. The one with the most
    symmetric middle planes wins, and among equals the smallest.

    A plane is symmetric if its error is below `tolerance`. The function mirrors surface samples in the plane and measures their
    distances to the surface. The error is the 90th percentile of the squared distances, over the squared diagonal of the part.

    Args:
        meshes: The meshes.
        groups: Meshes of each part.
        seed: Seed of the samples.
        samples: Number of samples of each part, at most 1e6.
        tolerance: Limit of the error, above 0. Unlike that of `find_symmetries`, it applies to squares.

    Returns:
        Centers, axes and half extents, as by `fit_boxes`, and the number of symmetric planes [G], from 0 to 3.
    """

def fit_aligned_boxes(meshes: Meshes, frame: F64, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Fit the smallest box along given axes to every group.

    Args:
        meshes: The meshes.
        frame: Axes of the boxes as rows [3, 3], orthonormal and right-handed.
        groups: Meshes of each part.

    Returns:
        Centers [G, 3], axes [G, 3, 3] and half extents [G, 3]. Axes and extents are in the order of `frame`.
    """

def find_symmetries(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 100, tolerance: float = 0.01
) -> tuple[U32, NDArray[np.uint8], U32, F64, F64, F64]:
    """Find mirror planes and rotation axes of every group.

    The error of a symmetry is the 90th percentile of the distances of mapped surface samples to the surface, over the diagonal
    of the part. Symmetries with an error below `tolerance` are reported. Of nearly parallel ones of a kind, only the best is.

    Args:
        meshes: The meshes.
        groups: Meshes of each part.
        seed: Seed of the samples.
        samples: Number of samples of each part, at most 1e6.
        tolerance: Limit of the error, above 0.

    Returns:
        Six arrays with a row for each of the K symmetries, by group and then mirror planes first:

        - groups [K]: Number of the group.
        - kinds [K]: 0 for a mirror plane, 1 for a rotation axis.
        - orders [K]: 2 for mirror planes. For axes, the largest of 2, 3, 4, 5, 6 and 8 that holds, or 0 if any angle does.
        - points [K, 3]: A point on the plane or axis.
        - directions [K, 3]: Unit normal of the plane, or unit direction of the axis.
        - errors [K]: Error of the symmetry.
    """

def find_round_pieces(
    meshes: Meshes, *, seed: int = 0, samples: int = 100, tolerance: float = 0.02
) -> tuple[U32, F64, F64, F64, F64]:
    """Find connected pieces of the meshes that are solids of revolution, such as pins, barrels, axles and knobs.

    Balls are left out, because they are round about any axis. So are pieces with fewer than 9 faces.

    Args:
        meshes: The meshes.
        seed: Seed of the samples.
        samples: Number of samples of each piece, as in `find_symmetries`.
        tolerance: Limit of the error of a rotation about the axis, as in `find_symmetries`.

    Returns:
        Five arrays with a row for each of the K pieces, in the order of the meshes:

        - meshes [K]: Index of the mesh.
        - middles [K, 3]: Point on the axis halfway between the ends of the piece.
        - directions [K, 3]: Unit direction of the axis.
        - radii [K]: Largest distance of the piece from its axis.
        - half_lengths [K]: Half of the length of the piece along its axis.
    """

def part_distances(
    meshes: Meshes, groups: Groups = None, pairs: U32 | None = None, *, max_distance: float = float("inf")
) -> tuple[U32, F64, F64, F64]:
    """Measure the exact distances between the surfaces of pairs of groups.

    The distance is 0 where surfaces touch or cross. Surfaces have no inside: the distance of a part within a closed part is
    that to the surface around it.

    Args:
        meshes: The meshes.
        groups: Meshes of each part.
        pairs: Indices of two different groups [E, 2]; None for all unordered pairs.
        max_distance: Largest distance, at least 0. Pairs farther apart are left out.

    Returns:
        Four arrays with a row for each remaining pair, in the order of `pairs`: the pair [E', 2], its distance [E'], and the
        nearest points [E', 3] on its first and on its second group.
    """

class InteractionRegions:
    """Interaction regions of E pairs of parts: the samples that face the other part, with their scores.

    The samples of pair e are the rows `offsets[e]` to `offsets[e + 1] - 1` of `samples` and `weights`.
    """

    @property
    def centroids(self) -> F64:
        """Mean [E, 3] of the moving part's samples, weighted by score, in the frame of the samples."""
    @property
    def scored(self) -> NDArray[np.bool_]:
        """True [E] if a sample of the moving part has a score. If not, the centroid is the mean of the nearest cross pairs."""
    @property
    def touching(self) -> NDArray[np.bool_]:
        """True [E] if the nearest samples of the two parts are within a hundredth of the diagonal of all samples."""
    @property
    def offsets(self) -> NDArray[np.int64]:
        """First row [E + 1] of each pair in `samples` and `weights`; the last entry is S."""
    @property
    def samples(self) -> U32:
        """Mesh index, and number of the sample in its mesh [S, 2]."""
    @property
    def weights(self) -> F64:
        """Scores [S], all positive. They are areas over the squared diagonal of the pair, so they do not depend on scale."""

def interaction_regions(points: F64 | F32, pairs: U32, groups: Groups = None) -> InteractionRegions:
    """Find interaction regions of pairs of parts, by the interaction bisector surface (IBS).

    The IBS is part of a Voronoi diagram. The diagram is that of the samples of both parts and of 20 x 40 points on a sphere
    around them, with a radius of 2/3 D. D is the diagonal of the box of all samples. The IBS consists of the ridges between
    samples of different parts. Each ridge is divided into the triangles between its mean corner and its edges.

    Each triangle adds this score to both samples of its ridge, or 0 where a factor is negative:

        area * (1 - d / (D / 2)) ** 20 * (1 - alpha / (pi / 3))

    Here d is the distance of the triangle's centroid to the two samples. alpha is the angle at the centroid between the normal
    of the ridge and the direction to a sample.

    Two shortcuts hardly change the scores. Far ridges are left out: the base of their power is below 0.8 times that of the
    nearest pair of samples, so they weigh about 1 % of it or less. If the parts are nearer than 0.05 D, the sphere has only
    4 x 8 points.

    If no sample of the moving part has a score, the centroid is the mean of the 10 nearest cross pairs of either part.

    Args:
        points: Surface samples [P, n, 3], the same number n for every mesh.
        pairs: Indices of groups [E, 2]: the moving part and the reference part.
        groups: Meshes of each part.

    Returns:
        The regions, in the order of `pairs`.

    Source: Hu et al., Interaction Context (ICON), 2015.
    """

def move_points(
    points: F32, kinds: NDArray[np.uint8], directions: F64, pivots: F64, angles: F64, shifts: F64, *, out: F32 | None = None
) -> F32:
    """Move points along candidate joints.

    Args:
        points: Points [N, 3].
        kinds: Kind of each of C joints [C]: 0 revolute, 1 prismatic, 2 screw.
        directions: Unit direction of each joint [C, 3].
        pivots: A point on the axis of each joint [C, 3]. Prismatic joints ignore it.
        angles: Rotation of each of D displacements [C, D], in radians. Prismatic joints ignore it.
        shifts: Translation along the direction [C, D]. Revolute joints ignore it.
        out: Array to write to, float32 [C, D, N, 3] in C order. It may not overlap an input.

    Returns:
        Moved points [C, D, N, 3]; `out` itself if it is given.

    Raises:
        ValueError: Moved points may not fit float32, or `out` cannot be written to.
    """

def sweep(
    meshes: Meshes,
    moving: Sequence[int],
    obstacles: Sequence[int],
    kinds: NDArray[np.uint8],
    directions: F64,
    pivots: F64,
    lower: F64,
    upper: F64,
    *,
    pitches: F64 | None = None,
    probes: int = 200,
    steps: int = 16,
    tolerance: float = 0.01,
    ignored_share: float = 0.005,
) -> tuple[F64, F64, F64]:
    """Measure how far a part can travel along each of C candidate joints before it collides.

    Contact and small overlaps at rest are no collisions. Each body is represented by probes: surface samples, moved inwards by
    `tolerance`. In a thinner wall they are moved to its middle. Probes that are inside the other body at rest are not used. A
    probe collides where its path crosses the surface of the other body.

    A mesh gets probes in proportion to the square root of its area, so that a small knob counts too. Probes are spread over the
    region that any of the candidates can reach. Results may therefore change a little with the other candidates of the call.

    Args:
        meshes: The meshes.
        moving: Indices of the meshes that move, as one body.
        obstacles: Indices of the meshes that stay, as the other body. The two lists share no mesh.
        kinds: Kind of each joint [C]: 0 revolute, 1 prismatic, 2 screw.
        directions: Unit direction of each joint [C, 3].
        pivots: A point on the axis of each joint [C, 3].
        lower: Travel to try downwards [C], at most 0: radians, or a length for prismatic joints.
        upper: Travel to try upwards [C], at least 0, in the same units.
        pitches: Length per radian of screws [C]; None for 0.
        probes: Largest number of probes of each body, at most 1e5.
        steps: Largest number of steps in each direction, at most 1e5. Paths are straight within a step.
        tolerance: Overlap at rest that is no collision, over the diagonal of the moving part. At least 0, below 1.
        ignored_share: Share of the probes of either body that may collide before the travel ends. At least 0, below 1.

    Returns:
        Three arrays:

        - free_lower [C]: Free travel downwards, or `lower` if nothing is in the way.
        - free_upper [C]: Free travel upwards, or `upper` if nothing is in the way.
        - penetration [C, 2]: Share of the probes that collide on the whole way, downwards and upwards. It is that of the body
          with the larger share.

        Free travel may be too long by about `tolerance` diagonals, because probes lie inside the surfaces.
    """

def box_intersection_volume(centers_a: F64, axes_a: F64, half_a: F64, centers_b: F64, axes_b: F64, half_b: F64) -> F64:
    """Compute the exact intersection volume of B pairs of oriented boxes.

    Args:
        centers_a: Centers of the first boxes [B, 3].
        axes_a: Their axes as rows [B, 3, 3], orthonormal. They may be left-handed.
        half_a: Their half extents along the axes [B, 3], at least 0.
        centers_b: Centers of the second boxes [B, 3].
        axes_b: Their axes.
        half_b: Their half extents.

    Returns:
        Volumes [B].
    """

def box_iou(centers_a: F64, axes_a: F64, half_a: F64, centers_b: F64, axes_b: F64, half_b: F64) -> F64:
    """Compute the exact intersection over union of B pairs of oriented boxes.

    Args:
        centers_a: Centers of the first boxes [B, 3].
        axes_a: Their axes as rows [B, 3, 3], orthonormal. They may be left-handed.
        half_a: Their half extents along the axes [B, 3], at least 0.
        centers_b: Centers of the second boxes [B, 3].
        axes_b: Their axes.
        half_b: Their half extents.

    Returns:
        Ratios [B], from 0 to 1; 0 for a pair without volume.
    """

def adjust_amodal_boxes(
    points: F64,
    offsets: NDArray[np.int64],
    owners: NDArray[np.int64],
    cameras: F64,
    centers: F64,
    axes: F64,
    half: F64,
    *,
    frames: NDArray[np.int64],
) -> tuple[F64, F64, F64]:
    """Adjust predicted amodal boxes of parts to F scans.

    A box keeps its axes. Each of its six sides follows these rules:

    - A side moves out to the outermost point of the part, so that no point is outside.
    - A side beyond all points of the part moves in to the outermost one, if most of the surface between should be visible and
      is not.
    - A side stays if that surface is occluded, seen at a grazing angle, or too close to tell.

    A box with fewer than 10 points stays as it is.

    Args:
        points: Points of all scans [N, 3], scan after scan, in the frame of the boxes.
        offsets: Bounds of the scans in `points` [F + 1], from 0 to N. Scan f has the points `offsets[f]` to
            `offsets[f + 1] - 1`.
        owners: Number of the box of each point [N], counted within its scan; negative for a point of no box.
        cameras: Position of the camera of each scan [F, 3].
        centers: Centers of the boxes [B, 3], scan after scan.
        axes: Axes of the boxes as rows [B, 3, 3], orthonormal.
        half: Half extents of the boxes [B, 3].
        frames: Bounds of the scans in the boxes [F + 1], from 0 to B.

    Returns:
        Centers, axes and half extents of the adjusted boxes.
    """

def nearest_neighbours(points: F32, count: int) -> NDArray[np.int64]:
    """Find the nearest neighbours of every point of B clouds.

    All pairs are compared, which is fast for clouds of some hundreds of points.

    Args:
        points: Clouds [B, n, 3].
        count: Number of neighbours, at least 1. The point itself counts as one.

    Returns:
        Indices into the cloud [B, n, min(count, n)], nearest first. Among equally far points the lower index comes first.
    """

def neighbour_argmax(features: F32, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Find the neighbour with the largest value of each feature, as in max pooling.

    Args:
        features: Features of the points of B clouds [B, n, C]. NaN counts as larger than all numbers.
        index: Indices of the k neighbours of m points [B, m, k], from 0 to n - 1. k is at least 1.

    Returns:
        Index of the point with the largest value [B, m, C]. Among equal values the first neighbour wins.
    """

def group_points(
    points: F32, centers: int, radius: float, members: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], F32]:
    """Sample centers of B clouds and group points around them, for a PointNet++.

    Args:
        points: Clouds [B, n, 3].
        centers: Number of centers. m is this number, or n if it is smaller.
        radius: Radius of a group.
        members: Number of points of a group. k is this number, or n if it is smaller.

    Returns:
        Four arrays; i is the smaller of 3 and m:

        - chosen [B, m]: Indices of the centers. The first is point 0. Each other one is farthest from all before it.
        - groups [B, m, k]: Indices of the first k points within `radius` of each center. If there are fewer, the first one is
          repeated.
        - nearest [B, n, i]: The centers nearest to every point, nearest first, as indices into `chosen`.
        - distances [B, n, i]: Distances to these centers.

    Source: Qi et al., PointNet++, 2017, section 3.
    """

def closest_points(meshes: Meshes, group: Sequence[int], points: F64) -> tuple[F64, F64, F64]:
    """Find the nearest point on the surface of a part, for each of N points.

    Args:
        meshes: The meshes.
        group: Indices of the meshes of the part.
        points: The points [N, 3].

    Returns:
        Distances [N], nearest points [N, 3], and the unit normals of their triangles [N, 3]. The normal of a triangle without
        area is zero.
    """

def closest_points_of_groups(meshes: Meshes, groups: Sequence[Sequence[int]], points: F64) -> tuple[F64, F64, F64]:
    """Find the nearest point on the surface of each of G parts, for N points each.

    Args:
        meshes: The meshes.
        groups: Indices of the meshes of each part.
        points: The points of each part [G, N, 3].

    Returns:
        Distances [G, N], nearest points [G, N, 3], and normals [G, N, 3], as `closest_points` has them.
    """

def surface_patches(meshes: Meshes, mesh: int, *, tolerance: float, crease: float) -> NDArray[np.uint32]:
    """Find the patches of a mesh: faces that are joined across edges without a concave crease between them.

    Solids that touch or were welded together meet at concave creases, or share an edge of more than two faces. A convex solid
    is one patch. Patches never join faces that have no vertex in common, directly or through others.

    Args:
        meshes: The meshes.
        mesh: Index of the mesh. Its vertices at one place have one index.
        tolerance: Largest distance of a vertex that lies on an edge, in the units of the mesh.
        crease: Largest angle between the normals of faces that are joined across a concave edge, in radians.

    Returns:
        Numbers [F] of the patches, from 0 in the order of their first faces.
    """

def render(
    meshes: Meshes, transforms: F64, size: tuple[int, int], focal: F64, center: F64, *, near: float, far: float
) -> tuple[F32, NDArray[np.int32]]:
    """Render depth images and part images with a pinhole camera.

    In the frame of the camera, x points to the right, y down, and z forward. The point (x, y, z) appears at column
    `focal[0] * x / z + center[0]` and row `focal[1] * y / z + center[1]`. The middle of pixel (column i, row j) is at
    (i + 1/2, j + 1/2). Both sides of a triangle are visible. Among meshes at the same depth, the first one is visible.

    Args:
        meshes: The meshes.
        transforms: Affine transforms into the frame of the camera, for every image and mesh [F, P, 4, 4].
        size: Width and height in pixels, at most 16384.
        focal: Focal lengths in pixels [2], above 0.
        center: Column and row of the optical axis in pixels [2].
        near: Smallest visible depth, above 0.
        far: Largest visible depth, above `near`.

    Returns:
        Depths along z [F, height, width], 0 where nothing is visible, and mesh indices [F, height, width], -1 there.
    """

Poses = tuple[F64, F64, F64]
"""Poses of N parts: rotations [N, 3, 3], scales [N] and translations [N, 3].

A pose maps source points: target = scale * rotation @ source + translation.
"""

def manhattan_frames(points: NDArray[np.float32], mask: NDArray[np.bool_]) -> F64:
    """Find the three perpendicular directions that most of the surface in each of F scans faces.

    Surface normals are estimated from the twelve nearest neighbours of each point. If a scan shows a single flat side, the
    other two axes are those of the rectangle of least area around it. A scan without points gives the identity.

    Args:
        points: Points of the scans [F, n, 3].
        mask: True for points that count [F, n].

    Returns:
        Rotations [F, 3, 3] with the axes as columns. The axes have no order and no sign.

    Source: Straub et al., The Manhattan Frame Model, 2018.
    """

def find_similarities(
    source: F64, target: F64, offsets: NDArray[np.int64], *, hypotheses: int, threshold: float, seed: int
) -> tuple[Poses, NDArray[np.bool_]]:
    """Find the similarity transform of each of P parts from point pairs with many outliers, by RANSAC.

    The cost of a transform is the sum of its squared residuals, each capped at the squared `threshold`. The search has three
    steps:

    1. Fit random triples of pairs, and keep the fit of least cost.
    2. Fit again to the inliers, as long as the cost falls.
    3. If there are at least 30 inliers, fit to all pairs, weighted by their probability of being inliers. Drop this fit if the
       cost rises by more than a tenth, or if more than half of the inliers are lost.

    Draws depend only on `seed` and the number of pairs. Costs are computed in single precision. Lengths should therefore be
    between 1e-18 and 1e18, and outliers at most a million times as far away as the other pairs extend.

    Args:
        source: Source points of all pairs [T, 3], part after part.
        target: Their target points [T, 3].
        offsets: Bounds of the parts in the pairs [P + 1], from 0 to T. Part i has the pairs `offsets[i]` to
            `offsets[i + 1] - 1`.
        hypotheses: Number of random triples for each part, at most 1e7.
        threshold: Largest residual of an inlier: a length in the frame of `target`, above 0.
        seed: Seed of the draws.

    Returns:
        Poses of the parts, and True for each pair that is an inlier [T]. A pose is NaN if no draw determines it. This is the
        case for fewer than three pairs, and for points on a line or all in one place.

    Source: Torr and Zisserman, MLESAC, 2000.
    """

def fit_constrained_poses(
    source: F64,
    target: F64,
    offsets: NDArray[np.int64],
    pairs: U32,
    kinds: NDArray[np.uint8],
    directions: F64,
    rotations: F64,
    scales: F64,
    translations: F64,
    *,
    frames: NDArray[np.int64],
    threshold: float,
) -> Poses:
    """Fit the poses of P parts to their inliers and to their joints, in least squares, from given poses near them.

    Both parts of a revolute or screw joint should rotate its direction alike; those of a prismatic joint, all directions. A
    joint weighs as much as the smaller number of inliers of its parts. Inliers are selected again after each fit, until they
    stay the same. Scales are kept. A part without inliers keeps its translation.

    Args:
        source: Source points of all pairs [T, 3], part after part.
        target: Their target points [T, 3].
        offsets: Bounds of the parts in the pairs [P + 1], as in `find_similarities`.
        pairs: Indices of the two parts of each joint [J, 2], both of the same object.
        kinds: Kind of each joint [J]: 0 revolute, 1 prismatic, 2 screw.
        directions: Unit direction of each joint [J, 3], in the frame of `source`.
        rotations: Rotations to start from [P, 3, 3].
        scales: Scales [P], above 0.
        translations: Translations to start from [P, 3].
        frames: Bounds of the objects in the parts [F + 1], from 0 to P. Object f has the parts `frames[f]` to
            `frames[f + 1] - 1`.
        threshold: Largest residual of an inlier: a length in the frame of `target`, above 0.

    Returns:
        Poses of the parts.
    """

def refine_poses(
    source: F64,
    target: F64,
    offsets: NDArray[np.int64],
    pairs: U32,
    kinds: NDArray[np.uint8],
    directions: F64,
    ranges: F64,
    axis_aligned: NDArray[np.bool_],
    rotations: F64,
    scales: F64,
    translations: F64,
    *,
    frames: NDArray[np.int64],
    threshold: float,
) -> Poses:
    """Refine the poses of P parts with joint ranges and axis-aligned parts.

    The cost of a pose is the sum of its residuals, each capped at `threshold`. The rules, from the root parts outwards:

    - A root part is the second part of no joint. If it is axis-aligned, it gets the rotation of least cost that aligns its
      observed surface with its axes. If that costs too much, its rotation is only corrected slightly.
    - The second part of a prismatic joint gets the rotation of the first.
    - The second part of a revolute or screw joint with a range gets the angle of least cost within the range. Three
      alternatives win only if they cost clearly less: an angle outside the range, an angle about the opposite direction, and
      the given rotation. If the part is axis-aligned, it is then aligned by a small rotation about the joint.
    - The second part of a revolute or screw joint without a range follows the rotation of the first.

    Scales are kept. A part without pairs keeps its pose.

    Args:
        source: Source points of all pairs [T, 3], part after part.
        target: Their target points [T, 3].
        offsets: Bounds of the parts in the pairs [P + 1], as in `find_similarities`.
        pairs: Indices of the two parts of each joint [J, 2], both of the same object.
        kinds: Kind of each joint [J]: 0 revolute, 1 prismatic, 2 screw.
        directions: Unit direction of each joint [J, 3], in the frame of `source`.
        ranges: Smallest and largest angle of the second part against the first [J, 2], in radians and at most 1000 in size.
            Both are NaN for an unknown range.
        axis_aligned: True for a part whose surface mostly faces the axes of `source` [P].
        rotations: Rotations to start from [P, 3, 3].
        scales: Scales [P], above 0.
        translations: Translations to start from [P, 3].
        frames: Bounds of the objects in the parts [F + 1], as in `fit_constrained_poses`.
        threshold: Cap on residuals, and limit of the residuals of inliers: a length in the frame of `target`, above 0.

    Returns:
        Poses of the parts.
    """

def find_constrained_poses(
    source: F64,
    target: F64,
    offsets: NDArray[np.int64],
    pairs: U32,
    kinds: NDArray[np.uint8],
    directions: F64,
    scales: F64,
    *,
    hypotheses: int,
    threshold: float,
    seed: int,
) -> tuple[Poses, Poses]:
    """Find the poses of the two parts of each of J joints by RANSAC, joint by joint, with given scales.

    Each hypothesis fits three random pairs of either part, and the joint. The hypothesis with the largest mean share of inliers
    of the two parts wins. It is then fitted to its inliers, as by `fit_constrained_poses`.

    Args:
        source: Source points of all pairs [T, 3], part after part.
        target: Their target points [T, 3].
        offsets: Bounds of the parts in the pairs [P + 1], as in `find_similarities`.
        pairs: Indices of the two parts of each joint [J, 2].
        kinds: Kind of each joint [J]: 0 revolute, 1 prismatic, 2 screw.
        directions: Unit direction of each joint [J, 3], in the frame of `source`.
        scales: Scales of the parts [P], above 0.
        hypotheses: Number of hypotheses for each joint, at most 1e7.
        threshold: Largest residual of an inlier: a length in the frame of `target`, above 0.
        seed: Seed of the draws.

    Returns:
        Poses of the first parts [J] and of the second parts [J]. Both are NaN if no draw determines them.

    Source: Li et al., Category-Level Articulated Object Pose Estimation, 2020, section 4.3.
    """
