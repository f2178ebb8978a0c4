"""Features of candidate axes relative to their part and its surroundings, the same for every kind of motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.features.candidate_lines import SAME_LINE, CandidateLines, LineSource
from kinmo.features.group_geometry import GroupGeometry
from kinmo.features.round_pieces import RoundPieces
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]

SPARSE_POINTS = 192
"""Surface samples for distances from the axes."""
ROTATED_POINTS = 64
"""Surface samples that are rotated to test rotational symmetry."""
ROTATIONS = np.radians([40.0, 90.0, 180.0])
"""Angles of that test, in radians."""
ALONG_AXIS = np.linspace(-0.5, 0.5, 9)
"""Positions along an axis, in lengths of the part, where its distances to surfaces are measured."""
MAX_ECCENTRICITY = 0.15
"""Largest distance between a symmetry axis and the part's centre, as a share of the part's radius about the axis."""
CLEAR_OFFSET = 0.02
"""Distance from the object's middle, in diagonals, beyond which it is clear to which side of it a part lies."""
COAXIAL = np.cos(np.radians(3.0))
"""Least cosine between an axis and a round piece about it (3 degrees)."""
MAX_PIECE_LENGTH = 2.0
"""Upper bound of the length of a round piece, in lengths of the part."""
DETAIL_AREA = 0.1
"""Details are leaves with less than this share of the part's surface."""


def line_features(shape: ShapeGeometry, group: GroupGeometry, lines: CandidateLines) -> F64:
    """Features [K, A] of the axes of a part: direction, position, contact, protrusion, surroundings and symmetry.

    The features do not change when the object turns about `up`.
    """
    up, d, p = shape.up, lines.directions, lines.pivots
    half = group.half_diagonal
    center = group.aligned.center

    def perpendicular(points: F64) -> F64:
        """Offsets [K, n, 3] of points [n, 3] from each axis."""
        offset: F64 = points[None] - p[:, None]
        offset -= np.einsum("kni,ki->kn", offset, d)[..., None] * d[:, None]
        return offset

    sparse = group.points[:: max(1, len(group.points) // SPARSE_POINTS)]
    radii = np.linalg.norm(perpendicular(sparse), axis=-1)
    reach = np.maximum(radii.max(axis=1), 1e-4)
    length = np.ptp(sparse @ d.T, axis=0) + 1e-4

    w = group.contact_weights
    contact = perpendicular(group.contact)
    contact_radii = np.linalg.norm(contact, axis=-1)
    contact_mean = np.einsum("n,kni->ki", w, contact)
    contact_along = (group.contact - center) @ d.T
    contact_middle = w @ contact_along
    spread = np.sqrt(np.maximum(w @ contact_along**2 - contact_middle**2, 0.0))
    protrusion = perpendicular(group.protrusion[None])[:, 0]

    from_center = p - center  # perpendicular to the axis, because p is the point of the axis nearest to the centre
    eccentricity = np.linalg.norm(from_center, axis=1)
    side = np.divide(from_center, eccentricity[:, None], where=eccentricity[:, None] > 1e-6, out=np.zeros_like(p))

    samples = (p[:, None] + (ALONG_AXIS * length[:, None])[..., None] * d[:, None]).reshape(-1, 3)
    own = _core.closest_points(shape.meshes, list(group.leaves), samples)[0].reshape(len(lines), -1)
    rest = np.ones_like(own)
    if group.rest:
        rest = _core.closest_points(shape.meshes, group.rest, samples)[0].reshape(len(lines), -1)

    from_middle = p - shape.middle
    half_object = 0.5 * np.maximum(shape.extents[1] - shape.extents[0], 1e-6)
    support = np.maximum(np.abs(side @ shape.frame.T) @ half_object, 1e-6)
    horizontal = from_middle - (from_middle @ up)[:, None] * up
    outward = center - shape.middle
    outward = outward - (outward @ up) * up
    outward = outward / max(float(np.linalg.norm(outward)), 0.02)
    # Right as seen from the front. Objects are made for right-handed people: doors of a kind hang on the same side.
    right_of_part, right_of_object = np.cross(up, front_normal(shape, group)), np.cross(up, outward)

    def offset_to_side(points: F64) -> F64:
        """Offset [K] of the mean of points [n, 3] from the part's centre towards each axis; 0 without points."""
        return side @ (points.mean(axis=0) - center) / half if len(points) else np.zeros(len(lines))

    def coaxial_piece(pieces: RoundPieces) -> F64:
        """Length and radius [K, 2] of the longest piece about each axis, relative to the part's; 0 without one."""
        if len(pieces) == 0:
            return np.zeros((len(lines), 2))
        about = np.abs(d @ pieces.directions.T) > COAXIAL
        about &= np.linalg.norm(perpendicular(pieces.middles), axis=-1) < SAME_LINE
        longest = np.where(about, pieces.half_lengths, -1.0).argmax(axis=1)
        long = np.minimum(2.0 * pieces.half_lengths[longest] / length, MAX_PIECE_LENGTH)
        thick = np.minimum(pieces.radii[longest] / reach, 1.0)
        return np.where(about.any(axis=1, keepdims=True), np.stack([long, thick], axis=1), 0.0)

    leaves, rest_leaves = np.array(group.leaves, np.int64), np.array(group.rest, np.int64)
    detail_area = DETAIL_AREA * shape.areas[leaves].sum()
    details, nearby = (some[shape.areas[some] < detail_area] for some in (leaves, rest_leaves))
    features = {
        "against up": np.abs(d @ up),
        "against outward": np.abs(d @ outward),
        "against the part's axes": np.abs(d @ group.sorted_axes.T),
        "against the object's axes": np.abs(d @ shape.frame[:2].T).max(axis=1),
        "against the contact": np.abs(d @ group.mean_toward),
        "eccentricity": np.stack([eccentricity / half, eccentricity, eccentricity / reach], axis=1),
        "side": np.stack([side @ up, side @ outward, np.abs(side @ group.sorted_axes[2])], axis=1),
        "left or right side": np.stack([side @ right_of_part, side @ right_of_object], axis=1),
        "position": np.stack([from_center @ up, from_center @ outward], axis=1) / half,
        "outer side": side @ (center - shape.middle) / half,
        "at the object's edge": np.sum(side * from_middle, axis=1) / support,
        "reach": np.log(reach),
        "lever": np.stack([radii.min(axis=1), radii.mean(axis=1), radii.std(axis=1)], axis=1) / reach[:, None],
        "length": np.log(length),
        "contact lever": np.stack([contact_radii @ w, contact_radii.min(axis=1)], axis=1) / reach[:, None],
        "contact distance": contact_radii @ w,
        "contact on the axis": np.stack([(contact_radii < near) @ w for near in (0.02, 0.06)], axis=1),
        "contact position": np.stack([contact_mean @ up, contact_mean @ outward], axis=1) / half,
        "contact along": np.stack([spread / length, np.abs(contact_middle) / length, np.log(spread + 1e-3)], axis=1),
        "contact side": np.sum(side * (contact_mean + from_center), axis=1) / half,
        "protrusion lever": np.linalg.norm(protrusion, axis=1) / reach,
        "protrusion position": np.stack([protrusion @ up, protrusion @ outward], axis=1) / half,
        "protrusion against contact": np.sum(protrusion * contact_mean, axis=1) / reach**2,
        "protrusion side": offset_to_side(group.protrusion[None]),
        "riders' side": offset_to_side(shape.centroids[group.riders]),
        "details' side": offset_to_side(shape.centroids[details]),
        "neighbours' side": offset_to_side(shape.centroids[nearby]),
        "distance to the part": np.stack([own.mean(axis=1), own.min(axis=1), own.max(axis=1)], axis=1),
        "distance to the rest": np.stack([rest.mean(axis=1), rest.min(axis=1), rest.max(axis=1)], axis=1),
        "height": (p @ up - shape.extents[0, 2]) / (2.0 * half_object[2]),
        "from the middle": np.stack([np.linalg.norm(horizontal, axis=1), horizontal @ outward], axis=1),
        "rotational mismatch": rotational_mismatch(group, lines, eccentricity / reach),
        "own round pieces": coaxial_piece(group.own_round),
        "neighbours' round pieces": coaxial_piece(group.neighbour_round),
        "sources": lines.sources[:, : LineSource.SYMMETRY_AXIS].astype(float),
        "agreeing sources": lines.sources.sum(axis=1),
    }
    return np.column_stack(list(features.values()))


def front_normal(shape: ShapeGeometry, group: GroupGeometry) -> F64:
    """Horizontal normal [3] of the part's thin side, away from the object's middle; shorter where its sign is unclear."""
    normal = group.sorted_axes[2]
    outside = float(np.clip(normal @ (group.aligned.center - shape.middle) / CLEAR_OFFSET, -1.0, 1.0))
    return np.asarray(outside * (normal - (normal @ shape.up) * shape.up))


def rotational_mismatch(group: GroupGeometry, lines: CandidateLines, eccentricity: F64) -> F64:
    """Mean distance [K, 3] between a part and itself after each of `ROTATIONS` about each axis, in tenths of its size.

    The mismatch is at most 1, and 1 for axes that are not central by their `eccentricity` [K], the distance from the part's
    centre as a share of its radius about the axis.
    """
    mismatch = np.ones((len(lines), len(ROTATIONS)))
    central = np.flatnonzero(eccentricity < MAX_ECCENTRICITY)
    if len(central) == 0:
        return mismatch
    few = group.points[:: max(1, len(group.points) // ROTATED_POINTS)].astype(np.float32)
    count = len(central)
    moved = _core.move_points(
        few, np.zeros(count, np.uint8), lines.directions[central], lines.pivots[central],
        np.tile(ROTATIONS, (count, 1)), np.zeros((count, len(ROTATIONS))),
    )  # fmt: skip
    distance = cKDTree(group.points).query(moved.reshape(-1, 3))[0].reshape(count, len(ROTATIONS), -1).mean(axis=-1)
    size = np.linalg.norm(np.ptp(group.points, axis=0)) + 1e-6
    mismatch[central] = np.minimum(10.0 * distance / size, 1.0)
    return mismatch
