"""Features of every candidate joint of every part: the input of the `kinmo` method's ranking network.

A *group* is a set of leaves that is treated as one rigid part: a node of the hierarchy or a body. All numbers are in the
normalised frame (lengths in diagonals of the object) and do not change when the object turns about `up`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, JointKind
from kinmo.features.candidate_lines import CENTRAL_SOURCES, CandidateLines, LineSource, candidate_lines, distinct_directions
from kinmo.features.group_geometry import GroupGeometry, group_geometries
from kinmo.features.line_features import line_features
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CandidateFeatures:
    """C candidate joints of U groups with their features; group `u` has the rows `offsets[u]:offsets[u + 1]`.

    Attributes:
        leaves ([M] int64): Positions of the leaves of all groups, those of one group ascending.
        leaf_offsets ([U + 1] int64): First entry of each group in `leaves`, and M.
        offsets ([U + 1] int64): First row of each group, and C.
        kinds ([C] int64): `JointKind.code`.
        directions ([C, 3] float64): Unit vectors.
        pivots ([C, 3] float64): Points of the axes nearest to the group's centre.
        features ([C, F] float32): Features of the candidates.
        centers ([U, 3] float64): Centres of the groups' boxes along the object's own axes.
        half_extents ([U, 3] float64): Half extents of the groups' minimum-volume boxes, the longest first.
        group_features ([U, G] float32): Features of the groups.
    """

    leaves: NDArray[np.int64]
    leaf_offsets: NDArray[np.int64]
    offsets: NDArray[np.int64]
    kinds: NDArray[np.int64]
    directions: F64
    pivots: F64
    features: NDArray[np.float32]
    centers: F64
    half_extents: F64
    group_features: NDArray[np.float32]

    def __len__(self) -> int:
        """Number of groups."""
        return len(self.centers)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """The arrays by name, as `PreparedShape.candidate_features` keeps them, with float64 rounded to float32."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value.astype(np.float32) if value.dtype == np.float64 else value for name, value in found.items()}

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[np.generic]]) -> CandidateFeatures:
        """Restore features from `arrays()`, with directions of unit length again."""
        found = {field.name: np.asarray(arrays[field.name]) for field in fields(cls)}
        for name in ("directions", "pivots", "centers", "half_extents"):
            found[name] = found[name].astype(np.float64)
        found["directions"] /= np.linalg.norm(found["directions"], axis=1, keepdims=True)
        return cls(**found)

    def joined(self, others: CandidateFeatures) -> CandidateFeatures:
        """These groups, followed by those of `others`."""
        names = [field.name for field in fields(self)]
        arrays = {name: np.concatenate([getattr(self, name), getattr(others, name)]) for name in names}
        for name in ("offsets", "leaf_offsets"):
            own, its = getattr(self, name), getattr(others, name)
            arrays[name] = np.concatenate([own, own[-1] + its[1:]])
        return CandidateFeatures(**arrays)

    @cached_property
    def group_of(self) -> Mapping[tuple[int, ...], int]:
        """Index of each group by the positions of its leaves, ascending."""
        ends = zip(self.leaf_offsets[:-1].tolist(), self.leaf_offsets[1:].tolist(), strict=True)
        return {tuple(self.leaves[start:end].tolist()): group for group, (start, end) in enumerate(ends)}

    def rows(self, group: int) -> slice:
        """Rows of one group's candidates."""
        return slice(int(self.offsets[group]), int(self.offsets[group + 1]))

    def counts(self, groups: Sequence[int]) -> list[int]:
        """Number of candidates of each of some groups."""
        return [int(self.offsets[group + 1] - self.offsets[group]) for group in groups]


def compute_candidate_features(shape: ShapeGeometry, groups: Sequence[Sequence[int]]) -> CandidateFeatures:
    """Candidate joints of every group, and their features.

    The features of a group do not depend on the other groups.

    Args:
        shape: Geometry of the shape.
        groups: Positions of the leaves of each group; at least one group.
    """
    leaves = [sorted(group) for group in groups]
    geometries = group_geometries(shape, leaves)
    found = []
    for group in geometries:
        round_lines = {
            LineSource.OWN_ROUND_PIECE: group.own_round.lines,
            LineSource.NEIGHBOUR_ROUND_PIECE: group.neighbour_round.lines,
        }
        lines = candidate_lines(group.minimum, group.aligned, group.contact, group.contact_weights, round_lines)
        kind, line = _motions(lines)
        motion = kind, lines.directions[line], lines.pivots[line]
        features = np.column_stack([line_features(shape, group, lines)[line], _motion_features(group, *motion)])
        found.append((*motion, features.astype(np.float32)))
    kinds, directions, pivots, of_candidates = (np.concatenate(values) for values in zip(*found, strict=True))
    return CandidateFeatures(
        leaves=np.concatenate([np.array(group, np.int64) for group in leaves]),
        leaf_offsets=np.concatenate([[0], np.cumsum([len(group) for group in leaves])]),
        offsets=np.concatenate([[0], np.cumsum([len(kinds) for kinds, *_ in found])]),
        kinds=kinds,
        directions=directions,
        pivots=pivots,
        features=of_candidates,
        centers=np.array([group.aligned.center for group in geometries]),
        half_extents=np.array([np.sort(group.minimum.half_extents)[::-1] for group in geometries]),
        group_features=np.array([_group_features(shape, group) for group in geometries], np.float32),
    )


def with_groups(
    known: CandidateFeatures | None, shape: ShapeGeometry, groups: Sequence[tuple[int, ...]]
) -> CandidateFeatures | None:
    """`known` with the features of all groups that it lacks; None if there are no groups at all."""
    wanted = [group for group in dict.fromkeys(groups) if known is None or group not in known.group_of]
    if not wanted:
        return known
    computed = CandidateFeatures.of(compute_candidate_features(shape, wanted).arrays())  # rounded as stored features are
    return computed if known is None else known.joined(computed)


def _motions(lines: CandidateLines) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Codes of the kinds [C] and indices of the lines [C] of all candidate joints.

    A part may turn about each line, slide along each distinct direction, and screw about each central line.
    """
    slides = distinct_directions(lines)
    screws = np.flatnonzero(lines.sources[:, list(CENTRAL_SOURCES)].any(axis=1))
    kinds = np.repeat([kind.code for kind in KINDS], [len(lines), len(slides), len(screws)])
    return kinds, np.concatenate([np.arange(len(lines)), slides, screws])


def _motion_features(group: GroupGeometry, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Features [C, 7] of each motion: its kind, and the share of its velocity that slides along or runs into the contact.

    Swept collisions (`kinmo.features.joint_limits`) are no features: they cost more time than all others and did not improve
    the ranking.
    """
    w = group.contact_weights
    turning = np.cross(directions[:, None], group.contact[None] - pivots[:, None])
    turning /= np.maximum(np.linalg.norm(turning, axis=-1).max(axis=1), 1e-6)[:, None, None]
    velocity = np.where((kinds == JointKind.PRISMATIC.code)[:, None, None], directions[:, None], turning)
    normal_velocity = np.einsum("hni,ni->hn", velocity, group.toward)
    speed = np.linalg.norm(velocity, axis=-1) @ w
    normal_speed = np.abs(normal_velocity) @ w
    one_sided = np.abs(normal_velocity @ w) / np.maximum(normal_speed, 1e-6)
    features = {
        "kind": np.eye(3)[kinds],
        "speed into the contact": normal_speed,
        "share of speed into the contact": normal_speed / np.maximum(speed, 1e-6),
        "one-sided contact": one_sided,
        "blocked in one direction": one_sided * normal_speed,
    }
    return np.column_stack(list(features.values()))


def _group_features(shape: ShapeGeometry, group: GroupGeometry) -> F64:
    """Size, position, flatness, roundness, contact and protrusion of a group [G]."""
    up, axes = shape.up, group.sorted_axes
    half = np.sort(group.minimum.half_extents)[::-1]
    low, high = shape.extents
    size = np.maximum(high - low, 1e-6)
    placed = group.points @ shape.frame.T
    heights = (placed[:, 2] - low[2]) / size[2]
    margins = np.minimum(placed.min(axis=0) - low, high - placed.max(axis=0)) / size
    axis_cosines = np.abs(group.normals @ axes.T)
    offset = group.aligned.center - shape.middle
    contact = group.contact_weights @ group.contact - group.aligned.center
    protrusion = group.protrusion - group.aligned.center
    area = shape.areas[list(group.leaves)].sum() / max(shape.areas.sum(), 1e-12)
    features = {
        "extents": np.log(half + 1e-3),
        "horizontal extents": np.log(np.sort(group.aligned.half_extents[:2]) + 1e-3),
        "height": np.log(group.aligned.half_extents[2] + 1e-3),
        "axes against up": np.abs(axes @ up),
        "area": np.log(area + 1e-4),
        "volume": np.log(group.aligned.volume + 1e-7),
        "tilt": min(group.minimum.volume / max(group.aligned.volume, 1e-12), 1.5),
        "heights": np.quantile(heights, [0.0, 0.5, 1.0]),
        "distance from the middle": np.linalg.norm(offset - (offset @ up) * up),
        "margins to the sides": np.sort(margins[:2]),
        "margin to top or bottom": margins[2],
        "flat faces": (axis_cosines > 0.97).mean(axis=0),
        "round faces": (axis_cosines.max(axis=1) < 0.9).mean(),
        "distances to the rest": np.log(np.quantile(group.distances, [0.0, 0.1, 0.5, 0.9, 1.0]) + 1e-3),
        "share in contact": [(group.distances < near).mean() for near in (0.003, 0.01, 0.03, 0.08)],
        "contact": [contact @ up / group.half_diagonal, np.linalg.norm(contact) / group.half_diagonal],
        "contact against up": group.mean_toward @ up,
        "one-sided contact": np.linalg.norm(group.mean_toward),
        "contact against axes": np.abs(axes @ group.mean_toward),
        "protrusion": [np.linalg.norm(protrusion - contact) / group.half_diagonal, protrusion @ up / group.half_diagonal],
        "counts": np.log1p([len(shape.areas), len(group.leaves), len(group.riders)]),
        "round pieces": np.log1p([len(group.own_round), len(group.neighbour_round)]),
        "stands alone": float(not group.rest),
        "object size": np.log([*np.sort(size[:2]), size[2]]),
    }
    return np.concatenate([np.atleast_1d(np.asarray(value, float)) for value in features.values()])
