"""What kinmo says of a shape: bodies, joints, and how sure it is of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import CoarseType, Joint, MotionType
from kinmo.core.mobility import Mobility


@dataclass(frozen=True, eq=False)
class JointEstimate:
    """One answer for one body: `joint` is None where the body is thought not to move.

    `score` is in [0, 1]; `terms` holds the score's parts by name (feasibility, direction, position, sweep, ...). `source` says
    where the axis comes from (the network itself, an edge of a box, ...).
    """

    joint: Joint | None
    type: MotionType | CoarseType
    score: float
    terms: Mapping[str, float] = field(default_factory=dict)
    source: str = "network"

    def turned(self, rotation: NDArray[np.float64]) -> JointEstimate:
        """The same answer in a frame to which `rotation` [3, 3] takes this one's."""
        return self if self.joint is None else replace(self, joint=self.joint.turned(rotation))


@dataclass(frozen=True, eq=False)
class Prediction:
    """A mobility tree for one shape, in the shape's own frame and lengths.

    `estimates[i]` holds the ranked answers for body `i` of `mobility`, best first; the first one is the body's joint.
    `network_estimates[i]` is what the motion GNN alone said of that body, before refinement. `doubt` is the largest chance that
    a part of those moves that are said to rest; 0 where none is told.
    """

    shape_id: str
    category: str
    mobility: Mobility
    estimates: tuple[tuple[JointEstimate, ...], ...]
    network_estimates: tuple[JointEstimate, ...]
    method: str
    doubt: float = 0.0

    def turned(self, rotation: NDArray[np.float64]) -> Prediction:
        """The same prediction in a frame to which `rotation` [3, 3] takes this one's."""
        return replace(
            self,
            mobility=self.mobility.turned(rotation),
            estimates=tuple(tuple(each.turned(rotation) for each in ranked) for ranked in self.estimates),
            network_estimates=tuple(each.turned(rotation) for each in self.network_estimates),
        )
