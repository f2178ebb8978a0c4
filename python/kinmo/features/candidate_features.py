"""Features of every candidate joint of every part: the input of the `kinmo` method's ranking network.

A *group* is a set of leaves that is treated as one rigid part: a node of the hierarchy or a body. All numbers are in the
normalised frame (lengths in diagonals of the object) and do not change when the object turns about `up`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo.features.candidate_lines import LineSource, candidate_lines
from kinmo.features.group_features import named_group_features
from kinmo.features.group_geometry import group_geometries
from kinmo.features.line_features import line_features
from kinmo.features.motion_features import candidate_motions, motion_features
from kinmo.features.shape_geometry import ShapeGeometry

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CandidateFeatures:
    """C candidate joints of U groups with their features; group `u` has the rows `offsets[u]:offsets[u + 1]`.

    Attributes:
        offsets ([U + 1] int64): First row of each group, and C.
        kinds ([C] int64): `JointKind.code`.
        directions ([C, 3] float64): Unit vectors.
        pivots ([C, 3] float64): Points of the axes nearest to the group's centre.
        features ([C, F] float32): Features of the candidates.
        centers ([U, 3] float64): Centres of the groups' boxes.
        group_features ([U, G] float32): Features of the groups.

    Example:
        >>> features = CandidateFeatures.of(prepared.candidate_features)
        >>> features.directions[features.rows(0)]  # axes of the candidate joints of the first group
    """

    offsets: NDArray[np.int64]
    kinds: NDArray[np.int64]
    directions: F64
    pivots: F64
    features: NDArray[np.float32]
    centers: F64
    group_features: NDArray[np.float32]

    def __len__(self) -> int:
        """Number of groups."""
        return len(self.centers)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """The arrays by name, as `PreparedShape.candidate_features` keeps them, with float64 rounded to float32."""
        return {
            name: value.astype(np.float32) if value.dtype == np.float64 else value
            for name, value in ((field.name, getattr(self, field.name)) for field in fields(self))
        }

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[np.generic]]) -> CandidateFeatures:
        """Restore features from `arrays()`, with directions of unit length again."""
        found = {field.name: np.asarray(arrays[field.name]) for field in fields(cls)}
        for name in ("directions", "pivots", "centers"):
            found[name] = found[name].astype(np.float64)
        found["directions"] /= np.linalg.norm(found["directions"], axis=1, keepdims=True)
        return cls(**found)

    def joined(self, others: CandidateFeatures) -> CandidateFeatures:
        """These groups, followed by those of `others`."""
        arrays = {
            field.name: np.concatenate([getattr(self, field.name), getattr(others, field.name)])
            for field in fields(self)
            if field.name != "offsets"
        }
        return CandidateFeatures(np.concatenate([self.offsets, self.offsets[-1] + others.offsets[1:]]), **arrays)

    def rows(self, group: int) -> slice:
        """Rows of one group's candidates."""
        return slice(int(self.offsets[group]), int(self.offsets[group + 1]))

    def counts(self, groups: Sequence[int]) -> list[int]:
        """Number of candidates of each of some groups."""
        return [int(self.offsets[group + 1] - self.offsets[group]) for group in groups]


def compute_candidate_features(
    shape: ShapeGeometry, groups: Sequence[Sequence[int]], part_sizes: F64 | None = None
) -> CandidateFeatures:
    """Candidate joints of every group, and their features.

    Args:
        shape: Geometry of the shape.
        groups: Positions of the leaves of each group; at least one group.
        part_sizes ([P, 3]): Half extents of the minimum-volume boxes of the parts that a group is compared with and counted
            among. Parts of the hierarchy do not depend on which leaves form a body. None: the sizes of the groups.
    """
    geometries = group_geometries(shape, groups)
    kinds, directions, pivots, features, counts = [], [], [], [], []
    for group in geometries:
        round_lines = {
            LineSource.OWN_ROUND_PIECE: group.own_round.lines,
            LineSource.NEIGHBOUR_ROUND_PIECE: group.neighbour_round.lines,
        }
        lines = candidate_lines(group.minimum, group.aligned, group.contact, group.contact_weights, round_lines)
        kind, line = candidate_motions(lines)
        kinds.append(kind)
        directions.append(lines.directions[line])
        pivots.append(lines.pivots[line])
        motions = motion_features(group, kind, directions[-1], pivots[-1])
        features.append(np.column_stack([line_features(shape, group, lines)[line], motions]))
        counts.append(len(kind))
    if part_sizes is None:
        part_sizes = np.array([group.minimum.half_extents for group in geometries])
    whole = [np.concatenate(list(named_group_features(shape, group, part_sizes).values())) for group in geometries]
    return CandidateFeatures(
        np.concatenate([[0], np.cumsum(counts)]),
        np.concatenate(kinds),
        np.concatenate(directions),
        np.concatenate(pivots),
        np.concatenate(features).astype(np.float32),
        np.array([group.aligned.center for group in geometries]),
        np.array(whole, np.float32),
    )
