"""Geometry of articulated objects, in Rust.

Every function takes and returns NumPy arrays, in any memory layout, runs without the GIL on all threads of rayon
(`RAYON_NUM_THREADS` bounds them), looks for Ctrl-C about every twentieth of a second (between two items of the batch, where one
takes longer), and gives the same result for a seed whatever the number of threads. A process forked from one that has used them
goes on with one thread. It raises ValueError, its text starting with the argument's name, for NaN, numbers beyond 1e60 and
counts out of range, empty meshes, indices out of range and wrong shapes; TypeError for another type of value; MemoryError where
the result would not fit. Lengths below 1e-100 may count as none.
P is the number of meshes, G of groups.
A group is a list of indices of meshes taken as one part; `groups=None` takes every mesh by itself.
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
    """The triangle meshes of the parts of one shape, checked once.

    `vertices[i]` [V, 3] float64, `faces[i]` [F, 3] uint32. Vertices that no face uses are ignored.
    """

    def __init__(self, vertices: Sequence[F64], faces: Sequence[U32]) -> None: ...
    def __len__(self) -> int: ...
    def areas(self) -> F64:
        """Surface area [P] of every mesh."""

def sample_surface(meshes: Meshes, count: int, seed: int = 0, *, blue_noise: bool = False) -> tuple[F32, F32, U32]:
    """Points on every mesh, uniform by area: points [P, count, 3], unit normals [P, count, 3], face indices [P, count].

    The order within a mesh is random, so that every prefix is uniform too. The draws are stratified by area. A mesh without
    area is sampled along its edges by length (one without length at its vertices), with unit normals perpendicular to them.
    The samples of a mesh depend on the mesh and `seed` alone. With `blue_noise` they are evenly spaced (Yuksel 2015, weighted
    sample elimination). `count` is at most 1e7, evenly spaced 1e5, and 1e8 for all meshes together. ValueError if a coordinate
    does not fit single precision.
    """

def fit_boxes(meshes: Meshes, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Boxes of minimum volume: centers [G, 3], axes [G, 3, 3] (unit rows, right-handed), half extents [G, 3].

    Axes are ordered by descending extent; the first two point towards positive coordinates (by their largest component). Of
    boxes of equal volume (to 1e-5) the one most aligned with the coordinate axes is taken. Flat and line-like parts have half
    extents of about zero (at most the rounding of their coordinates) in the missing directions.
    """

def fit_symmetric_boxes(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 100, tolerance: float = 1e-4
) -> tuple[F64, F64, F64, NDArray[np.uint8]]:
    """Boxes of Fish et al. 2014: centers, axes, half extents as of `fit_boxes`, and the number [G] of symmetric planes.

    Of the box of minimum volume and those on the facets of the convex hull, the one of least volume among those with three
    symmetric middle planes, or else two, or else one, or else of all. A plane is symmetric if the 90th percentile of the
    squared distances of `samples` mirrored surface samples to the surface, over the squared diagonal of the part, is below
    `tolerance`.
    """

def fit_aligned_boxes(meshes: Meshes, frame: F64, groups: Groups = None) -> tuple[F64, F64, F64]:
    """Boxes along the rows of `frame` [3, 3] (orthonormal, right-handed), kept in their order: as `fit_boxes`."""

def find_symmetries(
    meshes: Meshes, groups: Groups = None, *, seed: int = 0, samples: int = 100, tolerance: float = 0.01
) -> tuple[U32, NDArray[np.uint8], U32, F64, F64, F64]:
    """Mirror planes and rotation axes of every part, as K rows in the order of the groups.

    Returns the group [K], the kind [K] (0 reflection, 1 rotation), the order [K] (of a rotation the largest of 2, 3, 4, 5, 6
    and 8 that holds, 0 if any angle does; 2 for reflections), a point [K, 3] and the unit direction [K, 3] of the axis, or
    normal of the plane, and the error [K]: the 90th percentile of the distances of mapped surface samples to the surface over
    the part's diagonal, which is below `tolerance`.
    """

def find_round_pieces(
    meshes: Meshes, *, seed: int = 0, samples: int = 100, tolerance: float = 0.02
) -> tuple[U32, F64, F64, F64, F64]:
    """Connected pieces of the meshes that may be turned about a line by any angle: pins, barrels, axles, knobs. Balls are none.

    Returns, of K pieces in the order of the meshes, the mesh [K], the middle [K, 3] of the piece on its line, the line's unit
    direction [K, 3], and how far the piece reaches from the line and, along it, from the middle [K], in the lengths of the
    meshes. `samples` and `tolerance` are those of `find_symmetries`, of a piece by itself.
    """

def part_distances(
    meshes: Meshes, groups: Groups = None, pairs: U32 | None = None, *, max_distance: float = float("inf")
) -> tuple[U32, F64, F64, F64]:
    """Exact distances between the surfaces of parts, with the points at which they are taken.

    `pairs` [E, 2] holds indices of groups; None takes all unordered pairs. Pairs farther apart than `max_distance` are
    left out. Returns `(pairs [E', 2], distances [E'], witness_a [E', 3], witness_b [E', 3])` in the order of `pairs`, in
    the lengths of the meshes. The distance is 0 where surfaces touch or cross; it is a distance of *surfaces*: a closed
    part wholly inside another is as far away as the other's surface is.
    """

class InteractionRegions:
    """Interaction regions of E pairs: the samples that see the other part, and how much.

    The samples of pair e are the rows `offsets[e]:offsets[e + 1]` of `samples` and `weights`.
    """

    @property
    def centroids(self) -> F64:
        """Mean [E, 3] of the moving part's samples, weighted by score."""
    @property
    def scored(self) -> NDArray[np.bool_]:
        """[E]: False where no sample of the moving part has a score; the centroid then is the mean of the nearest pairs."""
    @property
    def touching(self) -> NDArray[np.bool_]:
        """[E]: whether the nearest samples of the two parts are within a hundredth of the diagonal of their box."""
    @property
    def offsets(self) -> NDArray[np.int64]:
        """[E + 1]."""
    @property
    def samples(self) -> U32:
        """[S, 2]: mesh and number of the sample within it."""
    @property
    def weights(self) -> F64:
        """[S]: scores, all positive; areas over the squared diagonal of the pair's box."""

def interaction_regions(points: F64 | F32, pairs: U32, groups: Groups = None) -> InteractionRegions:
    """Interaction regions of pairs of parts, by the interaction bisector surface (IBS) of Hu et al. 2015.

    `points` [P, n, 3] are n surface samples of every mesh; `pairs` [E, 2] are the groups (moving, reference). The IBS is
    what separates, in the Voronoi diagram of the samples of both parts and of 20 x 40 points of a sphere of radius 2/3
    diagonal around them, samples of different parts. Each ridge falls into the triangles between its mean corner and its
    edges. With D the diagonal of the box of all samples of the pair, d the distance of a triangle's centroid to the two
    samples of its ridge and alpha the angle there between the ridge's normal and the direction to a sample, a triangle
    gives both samples `area (1 - d / (D / 2))^20 (1 - alpha / (pi / 3))`, 0 where a factor is negative. The score of a
    sample is the sum over its triangles. Ridges so far away that the base of the power is below 0.8 times that of the
    nearest pair of samples (about 1 % of its weight) are left out, and where the parts are nearer than 0.05 D, 4 x 8 points
    stand for the sphere, which then bounds ridges of next to no weight. Where no sample of the moving part has a score,
    the centroid is the mean of the 10 nearest cross pairs from either side, and `scored` is False.
    """

def move_points(
    points: F32, kinds: NDArray[np.uint8], directions: F64, pivots: F64, angles: F64, shifts: F64, *, out: F32 | None = None
) -> F32:
    """Points [N, 3] moved along C candidate joints by D displacements each: [C, D, N, 3], written to `out` if given.

    `out` is contiguous in the order of C and overlaps no input.
    `kinds` [C]: 0 revolute, 1 prismatic, 2 screw; `directions` [C, 3], of length 1; `pivots` [C, 3]; `angles` [C, D] in
    radians, which prismatic joints ignore together with the pivot; `shifts` [C, D] in lengths, which revolute ones ignore.
    ValueError if points can leave single precision.
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
    """How far a part can travel along each of C candidate joints before it runs into something.

    The meshes `moving` move as one among the meshes `obstacles`. Joints are given as in `move_points`; `lower` [C] (at
    most 0) and `upper` [C] (at least 0) are the travels to try, radians for revolute and screw joints, lengths for
    prismatic ones; `pitches` [C] is the length per radian of screws (None: 0).

    Contact and small overlaps at rest are no collision: both bodies are stood for by `probes` surface samples moved inwards
    by `tolerance` diagonals of the moving part (in thinner walls to the middle), those that are inside the other body at
    rest are not used, and a probe collides where its path, in `steps` steps a direction, crosses the other body's surface.
    Meshes get probes as the roots of their areas: a knob can be in the way like a wall. The obstacles' probes are spread over
    what any of the candidates can reach, so travels may change a little with the candidates that are asked for together.

    Returns `(free_lower [C], free_upper [C], penetration [C, 2])`: the travel up to which at most `ignored_share` of the
    probes of either body have collided (the limit tried if nothing is in the way), too long by up to `tolerance` diagonals
    where the body starts in contact; and the share of the probes that collide on the whole way, downwards and upwards.
    """

def box_intersection_volume(centers_a: F64, axes_a: F64, half_a: F64, centers_b: F64, axes_b: F64, half_b: F64) -> F64:
    """Exact volumes [B] of the intersections of B pairs of oriented boxes.

    `centers` [B, 3], `axes` [B, 3, 3] with the unit axes as rows, `half` [B, 3] half of the extents along them.
    """

def box_iou(centers_a: F64, axes_a: F64, half_a: F64, centers_b: F64, axes_b: F64, half_b: F64) -> F64:
    """Exact intersection over union [B] of B pairs of oriented boxes, given as in `box_intersection_volume`.

    0 where neither box has volume.
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
    """The boxes of parts, their sides moved to where scans show them.

    The scans of F cameras, at `cameras` [F, 3], lie one after the other in `points` [N, 3], between the numbers `offsets` [F +
    1]; of the boxes, given as in `box_intersection_volume`, those of scan f are `frames[f]` to `frames[f + 1]`, and `owners`
    [N] has the number of the one among them that a point is of (-1: of none). No point of a box is outside: its sides go out
    to the outermost. Where a side is farther out than all points, and most of the surface between would be seen and is not,
    it goes in to the outermost. What is hidden, seen too flatly, or too thin to tell, stays, as do boxes with fewer than 10
    points, and axes.
    Returns `(centers, axes, half_extents)`.
    """

def nearest_neighbours(points: F32, count: int) -> NDArray[np.int64]:
    """Indices [B, n, min(count, n)] of the nearest points of each point of clouds [B, n, 3], itself among them, nearest first.

    Of points that are equally far those with lower indices come first. Meant for clouds of some hundreds of points: every pair
    is looked at.
    """

def neighbour_argmax(features: F32, index: NDArray[np.int64]) -> NDArray[np.int64]:
    """Which of the points `index` [B, m, k] of clouds with `features` [B, n, C] has the largest of each, [B, m, C].

    Of equal ones it is the first of `index`; NaN counts as larger than all numbers.
    """

def group_points(
    points: F32, centers: int, radius: float, members: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], F32]:
    """How a PointNet++ groups the points of clouds [B, n, 3] (Qi et al., 2017), about m `centers`, or fewer of fewer points.

    Returns `(chosen [B, m], groups [B, m, k], nearest [B, n, i], distances [B, n, i])`, all but the last indices. The first
    point is the first center `chosen`, and every other one is farthest from those before. `groups` are the first k points,
    `members` if there are as many, within `radius` of each center; where there are fewer, the first one is repeated. `nearest`
    are the three centers (or all, if there are fewer) that are nearest to every point, the nearest first, indices into
    `chosen`.
    """

def closest_points(meshes: Meshes, group: Sequence[int], points: F64) -> tuple[F64, F64, F64]:
    """Where the surfaces of the meshes `group` are nearest to points [N, 3].

    Returns `(distances [N], places [N, 3], normals [N, 3])`: the nearest places and the unit normals of their triangles (zero
    for a triangle without area).
    """

def render(
    meshes: Meshes, transforms: F64, size: tuple[int, int], focal: F64, center: F64, *, near: float, far: float
) -> tuple[F32, NDArray[np.int32]]:
    """What a pinhole camera sees: depths [F, height, width] (0 where nothing is), and parts (-1 where nothing is).

    `transforms` [F, P, 4, 4] bring every mesh into the camera's frame, once a picture: x to the right, y down, z forward.
    `size` is width and height, `focal` [2] and `center` [2] are in pixels; the point (x, y, z) is seen at column focal[0] x /
    z + center[0] and row focal[1] y / z + center[1], and the middle of the pixel (i, j) is at (i + 1/2, j + 1/2). Depths are
    distances along z, in single precision, and what is nearer than `near` or farther than `far` is not seen. Both sides of a
    triangle are.
    """

Poses = tuple[F64, F64, F64]
"""Rotations [N, 3, 3], scales [N] and translations [N, 3]: target = scale * rotation @ source + translation."""

def manhattan_frames(points: NDArray[np.float32], mask: NDArray[np.bool_]) -> F64:
    """Rotations [F, 3, 3] whose columns are the axes that most surfaces of scans [F, n, 3] face, of no order and no sign.

    Of their points those count that `mask` [F, n] marks. Normals are those of the twelve nearest points. What shows one flat
    side alone has its other axes along the rectangle of least area about it. Straub et al., The Manhattan Frame Model, 2018.
    """

def find_similarities(
    source: F64, target: F64, offsets: NDArray[np.int64], *, hypotheses: int, threshold: float, seed: int
) -> tuple[Poses, NDArray[np.bool_]]:
    """Similarities of P parts from pairs of points of which many are wrong, and which pairs are inliers [T].

    The pairs `source` [T, 3] and `target` [T, 3] from `offsets[i]` up to `offsets[i + 1]` are those of part i; `offsets` [P + 1]
    rises from 0 to T. Of so many fits to three pairs drawn at random the one with the smallest sum of squared residuals, each
    counted up to the squared `threshold`, is taken, and fitted anew to its inliers (residual below `threshold`) as long as that
    sum falls; and then, where there are 30 inliers or more, to all pairs, each weighed by how likely it is right, which may
    raise the sum by a tenth. What is drawn depends on `seed` and the number of pairs alone. NaN for a part that nothing drawn
    determines: of fewer than three pairs, or all on a line, or nearly all the same. Compared in single precision: lengths
    should be within 1e-18 and 1e18, and no pair farther off than a million times what the others span.
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
    """The poses of P parts that fit their inliers and their joints best, from poses near them; scales stay as they are.

    Pairs of points as in `find_similarities`. Joint j ties the parts `pairs[j]` [J, 2]; by its kind [J] (0 revolute, 1
    prismatic, 2 screw) both turn its direction [J, 3] (unit, where no part has moved) alike, or all directions. It weighs as
    much as the smaller number of inliers. Parts from `frames[f]` up to `frames[f + 1]` are one object; no joint ties two
    objects. A part without inliers keeps its translation.
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
    """The poses of P parts where what is known of the object leaves them, from poses near them; scales stay as they are.

    Arguments as in `fit_constrained_poses`; `ranges` [J, 2] are the angles in radians between which joints turn their second part against
    their first (NaN: not known), and `axis_aligned` [P] are parts whose surfaces face their axes. A part that hangs by nothing is
    turned, if axis_aligned, so that what is seen of it does, in that of all ways that fits best. One that slides is turned as what
    it slides in. One that turns is tried at all angles of its range, the best has the least sum of residuals (each counted up
    to `threshold`), and if axis_aligned it is turned about its joint, so that what is seen of it faces its axes. What pairs clearly
    tell of an angle out of the range, of one the other way round, or of no turn at all, is taken. What turns without a known
    range goes along; parts without pairs stay.
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
    """The poses of the two parts of each of J joints, looked for joint by joint, with the scales [P] of the parts.

    Arguments as in `fit_constrained_poses`. Of so many fits to three pairs of either part and the joint, the one with the largest mean of
    the two shares of inliers is taken, and fitted anew to them. NaN where nothing determines it. Li et al., Category-Level
    Articulated Object Pose Estimation, 2020, section 4.3.
    """
