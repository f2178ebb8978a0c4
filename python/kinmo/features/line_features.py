"""Numbers that describe an axis relative to its part and the rest, whatever the motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.features.candidate_lines import SAME_LINE, Lines, Source
from kinmo.features.round_pieces import RoundPieces
from kinmo.features.scene import Scene, Unit

F64 = NDArray[np.float64]

SPARSE_POINTS = 192
TURNED_POINTS = 64
ALONG = np.linspace(-0.5, 0.5, 9)
TURNS = np.radians([40.0, 90.0, 180.0])
ECCENTRIC = 0.15
"""An axis farther from the part's centre than this share of its reach is no axis of symmetry."""
UNCLEAR = 0.02
"""A part that lies less than this far to either side of the object's middle faces neither way for sure."""
ALONG_THE_AXIS = np.cos(np.radians(3.0))
"""Round pieces along a line to within this (cosine), and as near to it as SAME_LINE, lie about it."""
LONGEST = 2.0
"""Of a round piece, in lengths of the part: longer ones count as this."""
SMALL_LEAF = 0.1
"""A leaf with less than this share of the part's surface is a detail of it, or of what stands around it."""


def line_features(scene: Scene, unit: Unit, lines: Lines) -> F64:
    """Direction, place, contact, protrusion, surroundings and symmetry of each of K axes [K, A]."""
    up, d, p = scene.up, lines.directions, lines.pivots
    half = unit.half_diagonal
    center = unit.aligned.center

    def perpendicular(points: F64) -> F64:
        """Offsets [K, n, 3] of points [n, 3] from each axis."""
        offset: F64 = points[None] - p[:, None]
        offset -= np.einsum("kni,ki->kn", offset, d)[..., None] * d[:, None]
        return offset

    sparse = unit.points[:: max(1, len(unit.points) // SPARSE_POINTS)]
    away = np.linalg.norm(perpendicular(sparse), axis=-1)
    reach = np.maximum(away.max(axis=1), 1e-4)
    length = np.ptp(sparse @ d.T, axis=0) + 1e-4

    w = unit.contact_weights
    contact = perpendicular(unit.contact)
    contact_away = np.linalg.norm(contact, axis=-1)
    contact_mean = np.einsum("n,kni->ki", w, contact)
    contact_along = (unit.contact - center) @ d.T
    contact_middle = w @ contact_along
    spread = np.sqrt(np.maximum(w @ contact_along**2 - contact_middle**2, 0.0))
    protrusion = perpendicular(unit.protrusion[None])[:, 0]

    from_center = p - center  # perpendicular to the axis: p is the axis' point nearest to the centre
    eccentricity = np.linalg.norm(from_center, axis=1)
    aside = np.divide(from_center, eccentricity[:, None], where=eccentricity[:, None] > 1e-6, out=np.zeros_like(p))

    samples = (p[:, None] + (ALONG * length[:, None])[..., None] * d[:, None]).reshape(-1, 3)
    own = _core.closest_points(scene.meshes, list(unit.leaves), samples)[0].reshape(len(lines), -1)
    rest = _core.closest_points(scene.meshes, unit.rest, samples)[0].reshape(len(lines), -1) if unit.rest else np.ones_like(own)

    from_middle = p - scene.middle
    half_object = 0.5 * np.maximum(scene.extents[1] - scene.extents[0], 1e-6)
    support = np.maximum(np.abs(aside @ scene.frame.T) @ half_object, 1e-6)
    horizontal = from_middle - (from_middle @ up)[:, None] * up
    outward = center - scene.middle
    outward = outward - (outward @ up) * up
    outward = outward / max(float(np.linalg.norm(outward)), 0.02)
    # Seen from the front: objects are made for right-handed people, and doors of a kind hang on the same side.
    right_of_part, right_of_object = np.cross(up, facing(scene, unit)), np.cross(up, outward)

    def sideways(points: F64) -> F64:
        """How far [K] the mean of points [n, 3] lies towards the axis from the part's centre; 0 without points."""
        return aside @ (points.mean(axis=0) - center) / half if len(points) else np.zeros(len(lines))

    def round_about(pieces: RoundPieces) -> F64:
        """Length and radius [K, 2] of the longest of some pieces about each axis, to the part's own; 0 where there is none."""
        if len(pieces) == 0:
            return np.zeros((len(lines), 2))
        about = np.abs(d @ pieces.directions.T) > ALONG_THE_AXIS
        about &= np.linalg.norm(perpendicular(pieces.middles), axis=-1) < SAME_LINE
        longest = np.where(about, pieces.half_lengths, -1.0).argmax(axis=1)
        long = np.minimum(2.0 * pieces.half_lengths[longest] / length, LONGEST)
        thick = np.minimum(pieces.radii[longest] / reach, 1.0)
        return np.where(about.any(axis=1, keepdims=True), np.stack([long, thick], axis=1), 0.0)

    area = scene.areas[list(unit.leaves)]
    details = [leaf for leaf, a in zip(unit.leaves, area, strict=True) if a < SMALL_LEAF * area.sum()]
    nearby = [leaf for leaf in unit.rest if scene.areas[leaf] < SMALL_LEAF * area.sum()]
    features = {
        "against up": np.abs(d @ up),
        "against outward": np.abs(d @ outward),
        "against the part's axes": np.abs(d @ unit.sorted_axes.T),
        "against the object's axes": np.abs(d @ scene.frame[:2].T).max(axis=1),
        "against the contact": np.abs(d @ unit.mean_toward),
        "eccentricity": np.stack([eccentricity / half, eccentricity, eccentricity / reach], axis=1),
        "side": np.stack([aside @ up, aside @ outward, np.abs(aside @ unit.sorted_axes[2])], axis=1),
        "handed side": np.stack([aside @ right_of_part, aside @ right_of_object], axis=1),
        "place": np.stack([from_center @ up, from_center @ outward], axis=1) / half,
        "outer side": aside @ (center - scene.middle) / half,
        "at the object's edge": np.sum(aside * from_middle, axis=1) / support,
        "reach": np.log(reach),
        "lever": np.stack([away.min(axis=1), away.mean(axis=1), away.std(axis=1)], axis=1) / reach[:, None],
        "length": np.log(length),
        "contact lever": np.stack([contact_away @ w, contact_away.min(axis=1)], axis=1) / reach[:, None],
        "contact distance": contact_away @ w,
        "contact on the axis": np.stack([(contact_away < near) @ w for near in (0.02, 0.06)], axis=1),
        "contact place": np.stack([contact_mean @ up, contact_mean @ outward], axis=1) / half,
        "contact along": np.stack([spread / length, np.abs(contact_middle) / length, np.log(spread + 1e-3)], axis=1),
        "contact side": np.sum(aside * (contact_mean + from_center), axis=1) / half,
        "protrusion lever": np.linalg.norm(protrusion, axis=1) / reach,
        "protrusion place": np.stack([protrusion @ up, protrusion @ outward], axis=1) / half,
        "protrusion against contact": np.sum(protrusion * contact_mean, axis=1) / reach**2,
        "protrusion side": sideways(unit.protrusion[None]),
        "riders' side": sideways(scene.centroids[unit.riders]),
        "details' side": sideways(scene.centroids[details]),
        "neighbours' side": sideways(scene.centroids[nearby]),
        "on the part": np.stack([own.mean(axis=1), own.min(axis=1), own.max(axis=1)], axis=1),
        "on the rest": np.stack([rest.mean(axis=1), rest.min(axis=1), rest.max(axis=1)], axis=1),
        "height": (p @ up - scene.extents[0, 2]) / (2.0 * half_object[2]),
        "from the middle": np.stack([np.linalg.norm(horizontal, axis=1), horizontal @ outward], axis=1),
        "mismatch when turned": turned_mismatch(unit, lines, eccentricity / reach),
        "own round pieces": round_about(unit.own_round),
        "neighbours' round pieces": round_about(unit.next_round),
        "sources": lines.sources[:, : Source.SYMMETRY_AXIS].astype(float),
        "agreeing sources": lines.sources.sum(axis=1),
    }
    return np.column_stack(list(features.values()))


def facing(scene: Scene, unit: Unit) -> F64:
    """Where the part's thin side faces, horizontally and away from the object's middle [3]; shorter where that is unclear."""
    normal = unit.sorted_axes[2]
    outside = float(np.clip(normal @ (unit.aligned.center - scene.middle) / UNCLEAR, -1.0, 1.0))
    horizontal: F64 = outside * (normal - (normal @ scene.up) * scene.up)
    return horizontal


def turned_mismatch(unit: Unit, lines: Lines, eccentricity: F64) -> F64:
    """How far a part is from itself when turned about each axis [K, 3], in tenths of its size; 1 at most."""
    mismatch = np.ones((len(lines), len(TURNS)))
    central = np.flatnonzero(eccentricity < ECCENTRIC)
    if len(central) == 0:
        return mismatch
    few = unit.points[:: max(1, len(unit.points) // TURNED_POINTS)].astype(np.float32)
    count = len(central)
    moved = _core.move_points(
        few, np.zeros(count, np.uint8), lines.directions[central], lines.pivots[central],
        np.tile(TURNS, (count, 1)), np.zeros((count, len(TURNS))),
    )  # fmt: skip
    distance = cKDTree(unit.points).query(moved.reshape(-1, 3))[0].reshape(count, len(TURNS), -1).mean(axis=-1)
    size = np.linalg.norm(np.ptp(unit.points, axis=0)) + 1e-6
    mismatch[central] = np.minimum(10.0 * distance / size, 1.0)
    return mismatch
