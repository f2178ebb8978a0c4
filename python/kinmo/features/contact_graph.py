"""Graph of touching parts: pairs of leaves that are close, with features of their contact, sizes, places and names.

All lengths are in diagonals of the object. The features do not change when the object turns about `up`, when it is mirrored, or
when the order of the parts changes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.oriented_box import Box, have_similar_size
from kinmo.features.round_pieces import RoundPieces
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]

REACH = 0.03
"""Largest distance, in diagonals, of two leaves that form a pair."""
NEAREST = 3
"""Every leaf forms a pair with so many of its nearest leaves, however far."""
SAMPLES = 192
"""Surface samples of a leaf that its contact is measured at."""
NEAR = (0.003, 0.01, 0.03)
"""Distances, in diagonals, within which shares of the samples are counted."""
CONTACT_BAND = 0.005
"""Samples at most so much farther than the nearest one form the contact region."""
COAXIAL = np.cos(np.radians(3.0))
"""Least cosine between the lines of coaxial round pieces (3 degrees)."""
COAXIAL_OFFSET = 0.006
"""Largest distance between the lines of coaxial round pieces, in diagonals."""


@dataclass(frozen=True, eq=False)
class ContactGraph:
    """E directed pairs of leaves: both directions of every pair.

    Attributes:
        pairs ([E, 2] int64): Positions of the leaves; the second half has the pairs of the first half, reversed.
        features ([E, F] float32): Features of the second leaf as seen from the first.
    """

    pairs: NDArray[np.int64]
    features: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.pairs)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """The arrays by name."""
        return dict(vars(self))

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[np.generic]]) -> ContactGraph:
        """Restore a graph from `arrays()`."""
        return cls(**{field.name: np.asarray(arrays[field.name]) for field in fields(cls)})


def compute_contact_graph(shape: ShapeGeometry) -> ContactGraph:
    """The contact graph of the leaves of a shape."""
    pairs, gaps = close_pairs(shape)
    if not len(pairs):
        return ContactGraph(np.zeros((0, 2), np.int64), np.zeros((0, FEATURES), np.float32))
    count = len(shape.areas)
    leaves = [[leaf] for leaf in range(count)]
    minimum = [Box(*box) for box in zip(*_core.fit_boxes(shape.meshes, leaves), strict=True)]
    aligned = [Box(*box) for box in zip(*_core.fit_aligned_boxes(shape.meshes, shape.frame, leaves), strict=True)]
    pieces = [shape.round_pieces.subset(shape.round_pieces.leaves == leaf) for leaf in range(count)]
    linked = np.zeros((count, count), bool)
    linked[pairs[:, 0], pairs[:, 1]] = linked[pairs[:, 1], pairs[:, 0]] = True
    degree = np.log1p(linked.sum(axis=0))
    forward: list[list[float]] = []
    backward: list[list[float]] = []
    for (first, second), gap in zip(pairs.tolist(), gaps, strict=True):
        own, its = _contact(shape, first, second), _contact(shape, second, first)
        common = np.log1p((linked[first] & linked[second]).sum())
        shared = [
            np.log(gap + 1e-4),
            common,
            float(_coaxial(pieces[first], pieces[second])),
            *_box_relation(minimum[first], minimum[second], aligned[first], aligned[second]),
            *_contact_region(shape, own, its),
        ]
        for one, other, here, there, found in ((first, second, own, its, forward), (second, first, its, own, backward)):
            found.append([*shared, degree[one], degree[other], *_directed(shape, minimum, aligned, one, other, here, there)])
    features = np.array([*forward, *backward], np.float32)
    assert features.shape[1] == FEATURES
    return ContactGraph(np.concatenate([pairs, pairs[:, ::-1]]), features)


def close_pairs(shape: ShapeGeometry) -> tuple[NDArray[np.int64], F64]:
    """Pairs [P, 2] of leaves within `REACH`, or among the `NEAREST` of one of the two, and their distances [P]."""
    count = len(shape.areas)
    if count < 2:
        return np.zeros((0, 2), np.int64), np.zeros(0)
    pairs, gaps, _, _ = _core.part_distances(shape.meshes, max_distance=REACH)
    found = {(int(first), int(second)): float(gap) for (first, second), gap in zip(pairs, gaps, strict=True)}
    degree = np.bincount(pairs.ravel().astype(np.int64), minlength=count)
    lonely = np.flatnonzero(degree < min(NEAREST, count - 1))
    wanted = {tuple(sorted((int(leaf), int(other)))) for leaf in lonely for other in _nearest_boxes(shape, int(leaf))}
    missing = np.array(sorted(wanted - found.keys()), np.uint32).reshape(-1, 2)
    if len(missing):
        pairs, gaps, _, _ = _core.part_distances(shape.meshes, None, missing)
        found |= {(int(first), int(second)): float(gap) for (first, second), gap in zip(pairs, gaps, strict=True)}
    order = sorted(found)
    return np.array(order, np.int64), np.array([found[pair] for pair in order])


def _nearest_boxes(shape: ShapeGeometry, leaf: int) -> NDArray[np.int64]:
    """The `NEAREST` leaves whose axis-aligned boxes are nearest to that of a leaf."""
    low, high = shape.points.min(axis=1), shape.points.max(axis=1)
    gaps = np.linalg.norm(np.maximum(np.maximum(low - high[leaf], low[leaf] - high), 0.0), axis=1)
    gaps += 1e-3 * np.linalg.norm(shape.centroids - shape.centroids[leaf], axis=1)
    gaps[leaf] = np.inf
    return np.argsort(gaps, kind="stable")[: min(NEAREST, len(gaps) - 1)]


@dataclass(frozen=True, eq=False)
class _Contact:
    """Samples of one leaf near another.

    Attributes:
        shares ([3]): Shares of the samples within `NEAR`.
        points ([n, 3]): Samples in the contact region.
        toward ([3]): Mean unit vector from the other leaf to them; 0 where the surfaces meet.
        normal ([3, 3]): Mean outer product of the other leaf's normals there.
    """

    shares: F64
    points: F64
    toward: F64
    normal: F64


def _contact(shape: ShapeGeometry, leaf: int, other: int) -> _Contact:
    points = shape.points[leaf, :SAMPLES]
    distances, nearest, normals = _core.closest_points(shape.meshes, [other], points)
    near = distances <= distances.min() + CONTACT_BAND
    offset = points[near] - nearest[near]
    toward = (offset / np.maximum(np.linalg.norm(offset, axis=1, keepdims=True), 1e-4)).mean(axis=0)
    shares = np.array([(distances <= limit).mean() for limit in NEAR])
    return _Contact(shares, points[near], toward, np.einsum("ni,nj->ij", normals[near], normals[near]) / near.sum())


def _contact_region(shape: ShapeGeometry, own: _Contact, its: _Contact) -> list[float]:
    """Size and orientation of the contact region of a pair, the same from both sides."""
    points = np.concatenate([own.points, its.points])
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(points.T) if len(points) > 1 else np.zeros((3, 3))), 0.0))[::-1]
    tensor = 0.5 * (own.normal + its.normal)
    return [*np.log(spread + 1e-3), float(shape.up @ tensor @ shape.up), float(np.linalg.eigvalsh(tensor)[-1])]


def _box_relation(first: Box, second: Box, first_aligned: Box, second_aligned: Box) -> list[float]:
    """Relation of two boxes that is the same from both sides."""
    low = np.maximum(_low(first_aligned), _low(second_aligned))
    high = np.minimum(_high(first_aligned), _high(second_aligned))
    common = float(np.prod(np.maximum(high - low, 0.0) + 1e-3))
    union = np.maximum(_high(first_aligned), _high(second_aligned)) - np.minimum(_low(first_aligned), _low(second_aligned))
    volumes = [float(np.prod(2.0 * box.half_extents + 1e-3)) for box in (first_aligned, second_aligned)]
    cosines = np.abs(_sorted_axes(first) @ _sorted_axes(second).T)
    return [
        common / min(volumes),
        common / max(volumes),
        np.log(float(np.prod(union + 1e-3)) / sum(volumes)),
        float(have_similar_size(first.half_extents, second.half_extents)),
        *np.diag(cosines),
        float(cosines.max(axis=1).min()),
    ]


def _directed(
    shape: ShapeGeometry, minimum: Sequence[Box], aligned: Sequence[Box], one: int, other: int, here: _Contact, there: _Contact
) -> list[float]:
    """Sizes, places and contact of leaf `other` as seen from leaf `one`."""
    up, box, its = shape.up, minimum[one], minimum[other]
    sizes = np.sort(its.half_extents)[::-1] + 1e-3, np.sort(box.half_extents)[::-1] + 1e-3
    offset = aligned[other].center - aligned[one].center
    rise = float(offset @ up)
    reach = 2.0 * float(np.linalg.norm(box.half_extents)) + 1e-3
    middle = np.mean(here.points, axis=0) - aligned[one].center
    axes = _sorted_axes(box)
    low, high = _low(aligned[one]), _high(aligned[one])
    its_low, its_high = _low(aligned[other]), _high(aligned[other])
    size = high - low + 1e-3
    inside = np.maximum(np.minimum(high, its_high) - np.maximum(low, its_low), 0.0) / size
    return [
        np.log(shape.areas[other] + 1e-7) - np.log(shape.areas[one] + 1e-7),
        *np.log(sizes[0] / sizes[1]),
        *here.shares,
        *there.shares,
        rise / reach,
        float(np.linalg.norm(offset - rise * up)) / reach,
        float(np.linalg.norm(middle)) / reach,
        float(middle @ up) / reach,
        *np.sqrt(np.maximum(np.einsum("ai,ij,aj->a", axes, here.normal, axes), 0.0)),
        *np.abs(axes @ here.toward),
        float(here.toward @ up),
        float(np.linalg.norm(here.toward)),
        *np.sort(inside[:2]),
        inside[2],
        *np.sort(np.clip((its_high - high)[:2] / size[:2], -2.0, 2.0)),
        float(np.clip((its_high - high)[2] / size[2], -2.0, 2.0)),
        float(np.clip((low - its_low)[2] / size[2], -2.0, 2.0)),
    ]


FEATURES = 47
"""Number of features of a pair."""


def _low(box: Box) -> F64:
    """Lowest coordinates [3] of a box along the object's own axes, `up` last."""
    return np.asarray(box.axes @ box.center - box.half_extents)


def _high(box: Box) -> F64:
    """Highest coordinates [3] of a box along the object's own axes, `up` last."""
    return np.asarray(box.axes @ box.center + box.half_extents)


def _sorted_axes(box: Box) -> F64:
    """Axes [3, 3] of a box, the longest first."""
    return np.asarray(box.axes[np.argsort(-box.half_extents)])


def _coaxial(first: RoundPieces, second: RoundPieces) -> bool:
    """True if two leaves have round pieces about one line."""
    if not len(first) or not len(second):
        return False
    parallel = np.abs(first.directions @ second.directions.T) > COAXIAL
    offset = second.middles[None] - first.middles[:, None]
    distance = np.linalg.norm(np.cross(offset, first.directions[:, None]), axis=-1)
    return bool((parallel & (distance < COAXIAL_OFFSET)).any())
