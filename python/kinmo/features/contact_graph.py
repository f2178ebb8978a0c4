"""Graph of touching parts: pairs of leaves that are close, with features of their contact, sizes, places and names.

All lengths are in diagonals of the object. The features do not change when the object turns about `up`, when it is mirrored, or
when the order of the parts changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.oriented_box import have_similar_size
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
PAIRS_AT_ONCE = 1024
"""Pairs that are measured together. It bounds the memory, and does not change the result."""
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
    boxes = _LeafBoxes.of(_core.fit_boxes(shape.meshes, leaves), _core.fit_aligned_boxes(shape.meshes, shape.frame, leaves))
    pieces = [shape.round_pieces.subset(shape.round_pieces.leaves == leaf) for leaf in range(count)]
    linked = np.zeros((count, count), bool)
    linked[pairs[:, 0], pairs[:, 1]] = linked[pairs[:, 1], pairs[:, 0]] = True
    degree = np.log1p(linked.sum(axis=0))
    forward: list[F64] = []
    backward: list[F64] = []
    for start in range(0, len(pairs), PAIRS_AT_ONCE):
        first, second = pairs[start : start + PAIRS_AT_ONCE].T
        own, its = _contacts(shape, first, second), _contacts(shape, second, first)
        shared = [
            np.log(gaps[start : start + PAIRS_AT_ONCE] + 1e-4),
            np.log1p((linked[first] & linked[second]).sum(axis=1)),
            [float(_coaxial(pieces[one], pieces[other])) for one, other in zip(first, second, strict=True)],
            _box_relations(boxes, first, second),
            _contact_regions(shape, own, its),
        ]
        for one, other, here, there, found in ((first, second, own, its, forward), (second, first, its, own, backward)):
            directed = _directed(shape, boxes, one, other, here, there)
            found.append(np.column_stack([*shared, degree[one], degree[other], directed]))
    features = np.concatenate([*forward, *backward]).astype(np.float32)
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
class _LeafBoxes:
    """Boxes of all L leaves: the minimum-volume ones, and those along the object's own axes.

    Attributes:
        axes ([L, 3, 3]): Axes of the minimum-volume boxes, the longest first.
        half_extents ([L, 3]): Half extents of the minimum-volume boxes, in the order of `_core.fit_boxes`.
        centers ([L, 3]): Centres of the aligned boxes.
        low, high ([L, 3]): Coordinates of the aligned boxes along the object's own axes, `up` last.
        volumes ([L]): Volumes of the aligned boxes, with a margin.
    """

    axes: F64
    half_extents: F64
    centers: F64
    low: F64
    high: F64
    volumes: F64

    @classmethod
    def of(cls, minimum: tuple[F64, F64, F64], aligned: tuple[F64, F64, F64]) -> _LeafBoxes:
        """The boxes from centres, axes and half extents of the minimum-volume and the aligned boxes."""
        _, axes, half_extents = minimum
        centers, frames, half = aligned
        sorted_axes = np.take_along_axis(axes, np.argsort(-half_extents, axis=1)[:, :, None], axis=1)
        places = (frames @ centers[:, :, None])[:, :, 0]
        return cls(sorted_axes, half_extents, centers, places - half, places + half, np.prod(2.0 * half + 1e-3, axis=1))


@dataclass(frozen=True, eq=False)
class _Contacts:
    """Samples of P leaves near P other leaves.

    Attributes:
        points ([P, n, 3]): Samples of the leaves.
        near ([P, n] bool): Samples in the contact region.
        shares ([P, 3]): Shares of the samples within `NEAR`.
        middles ([P, 3]): Mean of the samples in the contact region.
        toward ([P, 3]): Mean unit vector from the other leaf to them; 0 where the surfaces meet.
        normals ([P, 3, 3]): Mean outer product of the other leaf's normals there.
    """

    points: F64
    near: NDArray[np.bool_]
    shares: F64
    middles: F64
    toward: F64
    normals: F64


def _contacts(shape: ShapeGeometry, leaves: NDArray[np.int64], others: NDArray[np.int64]) -> _Contacts:
    points = shape.points[leaves, :SAMPLES]
    distances, nearest, normals = _core.closest_points_of_groups(shape.meshes, others[:, None].tolist(), points)
    near = distances <= distances.min(axis=1, keepdims=True) + CONTACT_BAND
    count = near.sum(axis=1)[:, None]
    offset = points - nearest
    units = offset / np.maximum(np.linalg.norm(offset, axis=-1, keepdims=True), 1e-4)
    outer = [np.einsum("ni,nj->ij", some, some) for some in (rows[mask] for rows, mask in zip(normals, near, strict=True))]
    return _Contacts(
        points,
        near,
        np.stack([(distances <= limit).mean(axis=1) for limit in NEAR], axis=1),
        (points * near[..., None]).sum(axis=1) / count,
        (units * near[..., None]).sum(axis=1) / count,
        np.array(outer) / count[..., None],
    )


def _contact_regions(shape: ShapeGeometry, own: _Contacts, its: _Contacts) -> F64:
    """Sizes and orientations [P, 5] of the contact regions of pairs, the same from both sides."""
    rows = zip(own.points, own.near, its.points, its.near, strict=True)
    regions = (np.concatenate([here[close], there[closer]]) for here, close, there, closer in rows)
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(np.array([np.cov(region.T) for region in regions])), 0.0))[:, ::-1]
    tensors = 0.5 * (own.normals + its.normals)
    upright = np.einsum("i,pij,j->p", shape.up, tensors, shape.up)
    return np.column_stack([np.log(spread + 1e-3), upright, np.linalg.eigvalsh(tensors)[:, -1]])


def _box_relations(boxes: _LeafBoxes, first: NDArray[np.int64], second: NDArray[np.int64]) -> F64:
    """Relations [P, 8] of the boxes of pairs that are the same from both sides."""
    low, high = np.maximum(boxes.low[first], boxes.low[second]), np.minimum(boxes.high[first], boxes.high[second])
    common = np.prod(np.maximum(high - low, 0.0) + 1e-3, axis=1)
    union = np.maximum(boxes.high[first], boxes.high[second]) - np.minimum(boxes.low[first], boxes.low[second])
    volumes = boxes.volumes[first], boxes.volumes[second]
    cosines = np.abs(boxes.axes[first] @ boxes.axes[second].transpose(0, 2, 1))
    return np.column_stack(
        [
            common / np.minimum(*volumes),
            common / np.maximum(*volumes),
            np.log(np.prod(union + 1e-3, axis=1) / (volumes[0] + volumes[1])),
            have_similar_size(boxes.half_extents[first], boxes.half_extents[second]),
            np.diagonal(cosines, axis1=1, axis2=2),
            cosines.max(axis=2).min(axis=1),
        ]
    )


def _directed(
    shape: ShapeGeometry, boxes: _LeafBoxes, one: NDArray[np.int64], other: NDArray[np.int64], here: _Contacts, there: _Contacts
) -> F64:
    """Sizes, places and contact [P, 29] of the leaves `other` as seen from the leaves `one`."""
    up, axes = shape.up, boxes.axes[one]
    its_sizes, sizes = (np.sort(boxes.half_extents[leaves], axis=1)[:, ::-1] + 1e-3 for leaves in (other, one))
    offset = boxes.centers[other] - boxes.centers[one]
    rise = offset @ up
    reach = 2.0 * np.linalg.norm(boxes.half_extents[one], axis=1) + 1e-3
    middle = here.middles - boxes.centers[one]
    low, high, its_low, its_high = boxes.low[one], boxes.high[one], boxes.low[other], boxes.high[other]
    size = high - low + 1e-3
    inside = np.maximum(np.minimum(high, its_high) - np.maximum(low, its_low), 0.0) / size
    above, below = (np.clip(gap / size, -2.0, 2.0) for gap in (its_high - high, low - its_low))
    return np.column_stack(
        [
            np.log(shape.areas[other] + 1e-7) - np.log(shape.areas[one] + 1e-7),
            np.log(its_sizes / sizes),
            here.shares,
            there.shares,
            rise / reach,
            np.linalg.norm(offset - rise[:, None] * up, axis=1) / reach,
            np.linalg.norm(middle, axis=1) / reach,
            middle @ up / reach,
            np.sqrt(np.maximum(np.einsum("pai,pij,paj->pa", axes, here.normals, axes), 0.0)),
            np.abs(axes @ here.toward[:, :, None])[:, :, 0],
            here.toward @ up,
            np.linalg.norm(here.toward, axis=1),
            np.sort(inside[:, :2], axis=1),
            inside[:, 2],
            np.sort(above[:, :2], axis=1),
            above[:, 2],
            below[:, 2],
        ]
    )


FEATURES = 47
"""Number of features of a pair."""


def _coaxial(first: RoundPieces, second: RoundPieces) -> bool:
    """True if two leaves have round pieces about one line."""
    if not len(first) or not len(second):
        return False
    parallel = np.abs(first.directions @ second.directions.T) > COAXIAL
    offset = second.middles[None] - first.middles[:, None]
    distance = np.linalg.norm(np.cross(offset, first.directions[:, None]), axis=-1)
    return bool((parallel & (distance < COAXIAL_OFFSET)).any())
