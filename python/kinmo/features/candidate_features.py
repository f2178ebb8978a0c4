"""What speaks for and against every motion that a part might have: the input of the `kinmo` method's ranking network.

For each *unit* (a node of the hierarchy or a rigid body, taken as one part) the candidate axes are those of `kinmo.features.candidate_lines`,
and each is described by numbers that do not change when the object is turned about `up`. All lengths are in the normalised
frame (diagonals of the object).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo.features.candidate_lines import Source, candidate_lines
from kinmo.features.line_features import line_features
from kinmo.features.motion_features import PRISMATIC, REVOLUTE, SCREW, hypotheses_of, motion_features
from kinmo.features.part_features import unit_features
from kinmo.features.scene import Scene, see_units

__all__ = ["PRISMATIC", "REVOLUTE", "SCREW", "Evidence", "Scene", "gather", "see_units"]

F64 = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Evidence:
    """Hypotheses of U units, H in all: unit u owns rows `offsets[u]:offsets[u + 1]`.

    `kinds` [H] (REVOLUTE, PRISMATIC or SCREW), `directions` and `pivots` [H, 3], `features` [H, F] float32, `centers` [U, 3]
    (middle of the unit's box), `unit_features` [U, G] float32.
    """

    offsets: NDArray[np.int64]
    kinds: NDArray[np.int64]
    directions: F64
    pivots: F64
    features: NDArray[np.float32]
    centers: F64
    unit_features: NDArray[np.float32]

    def __len__(self) -> int:
        """How many units there are."""
        return len(self.centers)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """The arrays by name, as `PreparedShape.evidence` keeps them; geometry as float32."""
        return {
            name: value.astype(np.float32) if value.dtype == np.float64 else value
            for name, value in ((field.name, getattr(self, field.name)) for field in fields(self))
        }

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[np.generic]]) -> Evidence:
        """What `arrays` gave; directions have unit length again."""
        found = {field.name: np.asarray(arrays[field.name]) for field in fields(cls)}
        for name in ("directions", "pivots", "centers"):
            found[name] = found[name].astype(np.float64)
        found["directions"] /= np.linalg.norm(found["directions"], axis=1, keepdims=True)
        return cls(**found)

    def joined(self, others: Evidence) -> Evidence:
        """These units and after them those of `others`."""
        arrays = {
            field.name: np.concatenate([getattr(self, field.name), getattr(others, field.name)])
            for field in fields(self)
            if field.name != "offsets"
        }
        return Evidence(np.concatenate([self.offsets, self.offsets[-1] + others.offsets[1:]]), **arrays)

    def rows(self, unit: int) -> slice:
        """The rows of one unit's hypotheses."""
        return slice(int(self.offsets[unit]), int(self.offsets[unit + 1]))


def gather(scene: Scene, units: Sequence[Sequence[int]], part_sizes: F64 | None = None) -> Evidence:
    """Hypotheses and their evidence for every unit, a list of positions of leaves; at least one.

    `part_sizes` [P, 3] are half extents of the minimum-volume boxes of what a unit is compared with and counted among: the
    parts of the hierarchy, which are there whether or not it is known what forms a body. None: those of the units.
    """
    seen = see_units(scene, units)
    kinds, directions, pivots, features, counts = [], [], [], [], []
    for unit in seen:
        rounds = {Source.OWN_ROUND_PIECE: unit.own_round.lines, Source.NEXT_ROUND_PIECE: unit.next_round.lines}
        lines = candidate_lines(unit.minimum, unit.aligned, unit.contact, unit.contact_weights, rounds)
        kind, line = hypotheses_of(lines)
        kinds.append(kind)
        directions.append(lines.directions[line])
        pivots.append(lines.pivots[line])
        about = motion_features(unit, kind, directions[-1], pivots[-1])
        features.append(np.column_stack([line_features(scene, unit, lines)[line], about]))
        counts.append(len(kind))
    if part_sizes is None:
        part_sizes = np.array([unit.minimum.half_extents for unit in seen])
    return Evidence(
        np.concatenate([[0], np.cumsum(counts)]),
        np.concatenate(kinds),
        np.concatenate(directions),
        np.concatenate(pivots),
        np.concatenate(features).astype(np.float32),
        np.array([unit.aligned.center for unit in seen]),
        np.array([unit_features(scene, unit, part_sizes) for unit in seen], np.float32),
    )
