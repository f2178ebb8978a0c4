"""Candidate joints of one part: the container that both methods share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import KINDS, Joint, JointKind


@dataclass(frozen=True, eq=False)
class CandidateJoints:
    """C joints that one part might have, in one frame.

    Attributes:
        kinds ([C] uint8): `JointKind.code` of each candidate.
        directions ([C, 3] float64): Unit vectors along the axes.
        pivots ([C, 3] float64): One point of each axis.
        sources ([C]): Names of the geometry that the axes come from, such as "box edge".
    """

    kinds: NDArray[np.uint8]
    directions: NDArray[np.float64]
    pivots: NDArray[np.float64]
    sources: tuple[str, ...]

    @classmethod
    def of(cls, joints: Sequence[Joint], sources: Sequence[str]) -> CandidateJoints:
        """Candidates made of `joints` (at least one), without their limits."""
        return cls(
            np.array([joint.kind.code for joint in joints], np.uint8),
            np.array([joint.direction for joint in joints], np.float64),
            np.array([joint.pivot for joint in joints], np.float64),
            tuple(sources),
        )

    @classmethod
    def empty(cls) -> CandidateJoints:
        """No candidates."""
        return cls(np.empty(0, np.uint8), np.empty((0, 3)), np.empty((0, 3)), ())

    def __len__(self) -> int:
        return len(self.kinds)

    def kind(self, index: int) -> JointKind:
        """Kind of one candidate."""
        return KINDS[int(self.kinds[index])]

    def subset(self, rows: NDArray[np.intp]) -> CandidateJoints:
        """The candidates at the indices `rows`, in that order."""
        sources = tuple(self.sources[row] for row in rows)
        return CandidateJoints(self.kinds[rows], self.directions[rows], self.pivots[rows], sources)
