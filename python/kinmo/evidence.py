"""What speaks for and against every motion that a part might have: the input of the `kinmo` method's ranking network.

For each *unit* (a node of the hierarchy or a rigid body, taken as one part) the candidate axes are those of `kinmo.hypotheses`,
and each is described by numbers that do not change when the object is turned about `up`: how the part touches the rest along
the axis, where its centre and its protrusions lie, how it would slide along the contact, how far it would travel before it
collides, how symmetric it is. All lengths are in the normalised frame (diagonals of the object).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from kinmo import _core
from kinmo.box import Box
from kinmo.hypotheses import CENTRAL, Lines, candidate_lines, distinct_directions, object_frame

F64 = NDArray[np.float64]

REVOLUTE, PRISMATIC, SCREW = 0, 1, 2
TOUCHING = 0.008
"""Leaves nearer than this hang together."""
SURFACE_POINTS = 1024
SPARSE_POINTS = 192
CONTACT_POINTS = 96
CONTACT_SCALE = 0.01
LINE_POINTS = 9
TURNS = np.radians([40.0, 90.0, 180.0])
SWEPT_ANGLE = np.pi / 2
SWEPT_LENGTH = 0.3


@dataclass(frozen=True, eq=False)
class Evidence:
    """Hypotheses of U units, H in all: unit u owns rows `offsets[u]:offsets[u + 1]`.

    `kinds` [H] (0 turns, 1 slides, 2 screws), `directions` and `pivots` [H, 3], `features` [H, F] float32, `centers` [U, 3]
    (middle of the unit's aligned box), `unit_features` [U, G] float32.
    """

    offsets: NDArray[np.int64]
    kinds: NDArray[np.int64]
    directions: F64
    pivots: F64
    features: NDArray[np.float32]
    centers: F64
    unit_features: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Scene:
    """The leaves of one shape in the normalised frame.

    `points` and `normals` [L, n, 3], `areas` [L], `frame` [3, 3] (the object's own axes, `up` last), `extents` [2, 3] (low and
    high along them). `touching` [L, L] bool.
    """

    meshes: _core.Meshes
    points: F64
    normals: F64
    areas: F64
    frame: F64
    extents: F64
    touching: NDArray[np.bool_]

    @classmethod
    def of(cls, meshes: _core.Meshes, points: NDArray[np.float32], normals: NDArray[np.float32], areas: F64, up: F64) -> Scene:
        few = normals[:, :128].astype(float)
        weights = np.repeat(areas / few.shape[1], few.shape[1])
        frame = object_frame(few.reshape(-1, 3), weights, up)
        placed = points.reshape(-1, 3).astype(float) @ frame.T
        pairs, _, _, _ = _core.part_distances(meshes, max_distance=TOUCHING)
        touching = np.zeros((len(areas), len(areas)), bool)
        touching[pairs[:, 0], pairs[:, 1]] = touching[pairs[:, 1], pairs[:, 0]] = True
        return cls(
            meshes,
            points.astype(float),
            normals.astype(float),
            areas,
            frame,
            np.stack([placed.min(axis=0), placed.max(axis=0)]),
            touching,
        )

    def surface(self, leaves: Sequence[int], count: int) -> tuple[F64, F64]:
        """About `count` points of some leaves and their normals, in proportion to area."""
        area = self.areas[list(leaves)]
        share = area / area.sum() if area.sum() > 0 else np.full(len(area), 1.0 / len(area))
        available = self.points.shape[1]
        takes = np.minimum(np.ceil(share * count).astype(int), available)
        points = np.concatenate([self.points[leaf, :n] for leaf, n in zip(leaves, takes, strict=True)])
        normals = np.concatenate([self.normals[leaf, :n] for leaf, n in zip(leaves, takes, strict=True)])
        return points, normals

    def rest_of(self, unit: Sequence[int]) -> list[int]:
        """The leaves that stay when the unit moves: all others but those that hang on it alone."""
        others = np.setdiff1d(np.arange(len(self.areas)), unit)
        if len(others) == 0:
            return []
        _, component = connected_components(self.touching[np.ix_(others, others)], directed=False)
        mass = np.bincount(component, self.areas[others])
        hangs = np.zeros(len(mass), bool)
        touches = self.touching[np.ix_(others, list(unit))].any(axis=1)
        hangs[component[touches]] = True
        hangs[np.argmax(mass)] = False
        hangs &= mass < 0.5 * self.areas[list(unit)].sum()
        rest: list[int] = others[~hangs[component]].tolist()
        return rest


@dataclass(frozen=True, eq=False)
class Unit:
    """One part seen against the rest of its shape."""

    leaves: tuple[int, ...]
    rest: list[int]
    points: F64
    normals: F64
    distances: F64
    toward: F64
    """[n, 3], unit vector from the rest's nearest point to the part, or the rest's normal where they meet."""
    minimum: Box
    aligned: Box
    contact: NDArray[np.int64]
    contact_weights: F64
    symmetry_axes: F64

    @property
    def has_rest(self) -> bool:
        return bool(self.rest)


def see_units(scene: Scene, units: Sequence[tuple[int, ...]]) -> list[Unit]:
    """Boxes, contact and symmetry of every unit."""
    groups = [list(unit) for unit in units]
    minimum = [Box(*b) for b in zip(*_core.fit_boxes(scene.meshes, groups)[:3], strict=True)]
    aligned = [Box(*b) for b in zip(*_core.fit_aligned_boxes(scene.meshes, scene.frame, groups)[:3], strict=True)]
    owner, kind, _, point, direction, _ = _core.find_symmetries(scene.meshes, groups)
    seen = []
    for index, unit in enumerate(units):
        points, normals = scene.surface(unit, SURFACE_POINTS)
        rest = scene.rest_of(unit)
        if rest:
            distances, nearest, rest_normals = _core.closest_points(scene.meshes, rest, points)
            toward = points - nearest
            meets = distances < 1e-4
            facing = np.sign(np.sum(rest_normals * (aligned[index].center - nearest), axis=1, keepdims=True))
            toward = np.where(
                meets[:, None], rest_normals * np.where(facing == 0, 1.0, facing), toward / np.maximum(distances, 1e-9)[:, None]
            )
        else:
            distances, toward = np.ones(len(points)), np.zeros_like(points)
        contact = np.argsort(distances)[:CONTACT_POINTS]
        weights = np.exp(-(distances[contact] - distances[contact[0]]) / CONTACT_SCALE)
        axes = (owner == index) & (kind == 1)
        seen.append(
            Unit(
                tuple(unit), rest, points, normals, distances, toward, minimum[index], aligned[index], contact,
                weights / weights.sum(), np.stack([point[axes], direction[axes]], axis=1),
            )
        )  # fmt: skip
    return seen


def outward(scene: Scene, unit: Unit) -> tuple[F64, float]:
    """Horizontal unit vector from the object's middle to the part (zero if it is in the middle), and that distance."""
    up = scene.frame[2]
    middle = scene.extents.mean(axis=0) @ scene.frame
    offset = unit.aligned.center - middle
    offset = offset - (offset @ up) * up
    length = float(np.linalg.norm(offset))
    return (offset / length if length > 0.02 else np.zeros(3)), length


def unit_features(scene: Scene, unit: Unit, others: Sequence[Unit]) -> F64:
    """Numbers that describe a part as a whole [G]."""
    up = scene.frame[2]
    order = np.argsort(-unit.minimum.half_extents)
    half = unit.minimum.half_extents[order]
    axes = unit.minimum.axes[order]
    low, high = scene.extents
    size = np.maximum(high - low, 1e-6)
    placed = unit.points @ scene.frame.T
    heights = (placed[:, 2] - low[2]) / size[2]
    _, radius = outward(scene, unit)
    facing = np.abs(unit.normals @ axes.T)
    area = scene.areas[list(unit.leaves)].sum() / max(scene.areas.sum(), 1e-12)
    quantiles = np.quantile(unit.distances, [0.0, 0.1, 0.5, 0.9, 1.0])
    touching = [(unit.distances < t).mean() for t in (0.003, 0.01, 0.03, 0.08)]
    w = unit.contact_weights
    contact = w @ unit.points[unit.contact]
    toward = w @ unit.toward[unit.contact]
    offset = contact - unit.aligned.center
    scale = max(float(np.linalg.norm(half)), 1e-6)
    sizes = np.array([np.sort(o.minimum.half_extents)[::-1] for o in others])
    similar = (np.abs(np.log((sizes + 0.003) / (half + 0.003))) < 0.15).all(axis=1).sum() - 1
    aligned_half = unit.aligned.half_extents
    tilt = unit.minimum.volume / max(unit.aligned.volume, 1e-12)
    side = np.minimum(placed.min(axis=0) - low, high - placed.max(axis=0)) / size
    protrusion = unit.points[np.argmax(unit.distances)]
    return np.concatenate(
        [
            np.log(half + 1e-3), np.log(aligned_half[[0, 1]].max(keepdims=True) + 1e-3), np.log(aligned_half[2:] + 1e-3),
            np.abs(axes @ up), [np.log(area + 1e-4), np.log(unit.aligned.volume + 1e-7), min(tilt, 1.5)], np.quantile(heights,
            [0.0, 0.5, 1.0]), [radius], np.sort(side[:2]), [side[2]], (facing > 0.97).mean(axis=0), [(facing.max(axis=1) <
            0.9).mean()], np.log(quantiles + 1e-3), touching, [offset @ up / scale, np.linalg.norm(offset) / scale, toward @ up,
            np.linalg.norm(toward)], np.abs(axes @ toward), [np.linalg.norm(protrusion - contact) / scale, (protrusion -
            contact) @ up / scale], [np.log1p(similar), np.log1p(len(others)), np.log1p(len(scene.areas)),
            np.log1p(len(unit.leaves)), float(unit.has_rest)], np.log(np.sort(size[:2])), [np.log(size[2]),
            float(len(unit.symmetry_axes) > 0)], ] )  # fmt: skip


def hypotheses_of(lines: Lines) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Kind [h] and line [h] of every hypothesis over `lines`: turn about each, slide along each direction, screw about the
    central ones.
    """
    slides = distinct_directions(lines)
    screws = np.flatnonzero(lines.sources[:, list(CENTRAL)].any(axis=1))
    kinds = np.repeat([REVOLUTE, PRISMATIC, SCREW], [len(lines), len(slides), len(screws)])
    return kinds, np.concatenate([np.arange(len(lines)), slides, screws])


def line_features(scene: Scene, unit: Unit, lines: Lines) -> F64:
    """Numbers that describe each axis relative to the part, whatever the motion [K, A]."""
    up = scene.frame[2]
    out, _ = outward(scene, unit)
    d, p = lines.directions, lines.pivots
    order = np.argsort(-unit.minimum.half_extents)
    half = np.linalg.norm(unit.minimum.half_extents)
    axes = unit.minimum.axes[order]
    sparse = unit.points[:: max(1, len(unit.points) // SPARSE_POINTS)]

    def perpendicular(points: F64) -> F64:
        offset = points[None] - p[:, None]
        return offset - np.einsum("kni,ki->kn", offset, d)[..., None] * d[:, None]

    away = np.linalg.norm(perpendicular(sparse), axis=-1)
    reach = np.maximum(away.max(axis=1), 1e-4)
    contact = unit.points[unit.contact]
    w = unit.contact_weights
    contact_offset = perpendicular(contact)
    contact_away = np.linalg.norm(contact_offset, axis=-1)
    contact_mean = np.einsum("n,kni->ki", w, contact_offset)
    along = np.einsum("ni,ki->kn", contact - unit.aligned.center, d)
    along_mean = along @ w
    extent = np.ptp(np.einsum("ni,ki->kn", sparse, d), axis=1) + 1e-4
    spread = np.sqrt(np.maximum((along**2) @ w - along_mean**2, 0.0))
    protrusion = unit.points[np.argsort(unit.distances)[-8:]]
    protrusion_offset = perpendicular(protrusion).mean(axis=1)
    center = unit.aligned.center - p
    center -= np.sum(center * d, axis=1, keepdims=True) * d
    opposite = np.sum(protrusion_offset * contact_mean, axis=1) / (reach * reach)
    beyond = np.sum(protrusion_offset * center, axis=1) / (reach * reach)

    steps = np.linspace(-0.5, 0.5, LINE_POINTS)
    samples = p[:, None] + (steps[None] * extent[:, None])[..., None] * d[:, None]
    flat = samples.reshape(-1, 3)
    own = _core.closest_points(scene.meshes, list(unit.leaves), flat)[0].reshape(len(lines), -1)
    rest = (
        _core.closest_points(scene.meshes, unit.rest, flat)[0].reshape(len(lines), -1) if unit.has_rest else np.ones_like(own)
    )

    middle = scene.extents.mean(axis=0) @ scene.frame
    from_middle = p - middle
    low, high = scene.extents
    height = ((p @ up) - low[2]) / max(high[2] - low[2], 1e-6)
    radial = from_middle - (from_middle @ up)[:, None] * up
    third = axes[2]
    columns = [
        np.abs(d @ up),
        np.abs(d @ out),
        np.abs(d @ axes.T),
        np.abs(d @ scene.frame[:2].T).max(axis=1),
        np.abs(d @ (w @ unit.toward[unit.contact])),
        np.linalg.norm(center, axis=1) / half,
        center @ up / half,
        center @ out / half,
        np.abs(center @ third) / half,
        np.linalg.norm(center, axis=1),
        np.log(reach),
        away.min(axis=1) / reach,
        away.mean(axis=1) / reach,
        away.std(axis=1) / reach,
        np.log(extent),
        contact_away @ w / reach,
        contact_away.min(axis=1) / reach,
        contact_away @ w,
        (contact_away < 0.02) @ w,
        (contact_away < 0.06) @ w,
        contact_mean @ up / half,
        contact_mean @ out / half,
        spread / extent,
        np.abs(along_mean) / extent,
        np.log(spread + 1e-3),
        np.linalg.norm(protrusion_offset, axis=1) / reach,
        protrusion_offset @ up / half,
        protrusion_offset @ out / half,
        opposite,
        beyond,
        own.mean(axis=1),
        own.min(axis=1),
        own.max(axis=1),
        rest.mean(axis=1),
        rest.min(axis=1),
        rest.max(axis=1),
        height,
        np.linalg.norm(radial, axis=1),
        radial @ out,
        turned_mismatch(unit, lines, np.linalg.norm(center, axis=1) / reach),
        lines.sources.astype(float),
        lines.sources.sum(axis=1),
    ]  # fmt: skip return np.column_stack(columns)


def turned_mismatch(unit: Unit, lines: Lines, eccentricity: F64) -> F64:
    """How far the part is from itself when turned about each axis [K, 3]: mean distance over reach; 1 for axes off its centre."""
    mismatch = np.ones((len(lines), len(TURNS)))
    central = np.flatnonzero(eccentricity < 0.15)
    if len(central) == 0:
        return mismatch
    tree = cKDTree(unit.points)
    few = unit.points[:: max(1, len(unit.points) // 64)]
    count = len(central)
    moved = _core.move_points(
        few.astype(np.float32), np.zeros(count, np.uint8), lines.directions[central], lines.pivots[central],
        np.tile(TURNS, (count, 1)), np.zeros((count, len(TURNS))),
    )  # fmt: skip
    distance = tree.query(moved.reshape(-1, 3))[0].reshape(count, len(TURNS), -1).mean(axis=-1)
    size = np.linalg.norm(np.ptp(unit.points, axis=0)) + 1e-6
    mismatch[central] = np.minimum(distance / size * 10.0, 1.0)
    return mismatch


def motion_features(scene: Scene, unit: Unit, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Numbers that describe each motion against the rest [h, B]: sliding along the contact, and free travel."""
    contact = unit.points[unit.contact]
    w = unit.contact_weights
    turning = np.cross(directions[:, None], contact[None] - pivots[:, None])
    turning /= np.maximum(np.linalg.norm(turning, axis=-1).max(axis=1), 1e-6)[:, None, None]
    velocity = np.where((kinds == PRISMATIC)[:, None, None], directions[:, None], turning)
    across = np.einsum("hni,ni->hn", velocity, unit.toward[unit.contact])
    speed = np.linalg.norm(velocity, axis=-1)
    normal = np.abs(across) @ w
    sliding = normal / np.maximum(speed @ w, 1e-6)
    one_sided = np.abs(across @ w) / np.maximum(normal, 1e-6)
    if unit.has_rest:
        limit = np.where(kinds == PRISMATIC, SWEPT_LENGTH, SWEPT_ANGLE)
        swept = np.where(kinds == PRISMATIC, 1, 0).astype(np.uint8)
        lower, upper, penetration = _core.sweep(
            scene.meshes, list(unit.leaves), unit.rest, swept, directions, pivots, -limit, limit, probes=96, steps=8
        )
        free = np.sort(np.abs(np.stack([lower, upper], axis=1)) / limit[:, None], axis=1)
        depth = np.sort(penetration, axis=1)
    else:
        free, depth = np.ones((len(kinds), 2)), np.zeros((len(kinds), 2))
    return np.column_stack([np.eye(3)[kinds], normal, sliding, one_sided, one_sided * normal, free, depth])


def gather(scene: Scene, units: Sequence[tuple[int, ...]]) -> Evidence:
    """Hypotheses and their evidence for every unit, a tuple of positions of leaves."""
    seen = see_units(scene, units)
    kinds, directions, pivots, features, wholes, counts = [], [], [], [], [], []
    for unit in seen:
        lines = candidate_lines(unit.minimum, unit.aligned, unit.points[unit.contact], unit.contact_weights, unit.symmetry_axes)
        kind, line = hypotheses_of(lines)
        kinds.append(kind)
        directions.append(lines.directions[line])
        pivots.append(lines.pivots[line])
        motion = motion_features(scene, unit, kind, directions[-1], pivots[-1])
        features.append(np.column_stack([line_features(scene, unit, lines)[line], motion]))
        wholes.append(unit_features(scene, unit, seen))
        counts.append(len(kind))
    return Evidence(
        np.concatenate([[0], np.cumsum(counts)]),
        np.concatenate(kinds),
        np.concatenate(directions),
        np.concatenate(pivots),
        np.concatenate(features).astype(np.float32),
        np.array([unit.aligned.center for unit in seen]),
        np.array(wholes, np.float32),
    )
