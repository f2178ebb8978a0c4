"""What networks say of the points of a scan, and what that says of the object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.scans.articulated_object import Structure
from kinmo.scans.input_frame import InputFrame

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

MIDDLE = np.full(3, 0.5)
"""Of a part in NPCS, and of the object in NAOCS."""

LEAST_LENGTH = 1e-6
"""Of the median of said axes, below which it is no direction."""


@dataclass(frozen=True, eq=False)
class Layout:
    """What is said of an object with K parts as a whole: `half_sizes` [K, 3] of the parts' boxes in NPCS, and `pivots`
    [K - 1, 3], points of the joints' axes in NAOCS.
    """

    half_sizes: F64
    pivots: F64


@dataclass(frozen=True, eq=False)
class PointAnswers:
    """What is said of the n points of one scan of an object with K parts.

    `points` [n, 3] are those of the camera as `frame` brings them to networks. `parts` [n] is the part of each (-1: of none),
    `npcs` [n, 3] its place on that. `part_scales` [K] and `part_shifts` [K, 3] take NPCS to NAOCS. `joints` [n] is the joint
    that a point tells of (0: none, j: that of part j), and `axes` and `pivots` [n, 3] in NAOCS what it says of its axis.
    `layout` counts before that, where there is one.
    """

    frame: InputFrame
    points: F64
    parts: I64
    npcs: F64
    part_scales: F64
    part_shifts: F64
    joints: I64
    axes: F64
    pivots: F64
    layout: Layout | None = None

    def on_part(self, part: int) -> tuple[F64, F64]:
        """Places on a part and the points there, both [m, 3]."""
        own = self.parts == part
        return self.npcs[own], self.points[own]

    def on(self, part: int, naocs: F64) -> F64:
        """Places [..., 3] on the whole object, in the coordinates of a part."""
        return np.asarray((naocs - self.part_shifts[part]) / self.part_scales[part])


def said_half_sizes(answer: PointAnswers) -> F64:
    """Of the boxes [K, 3] in NPCS, whose middles are at `MIDDLE`; without a layout those that hold what is seen, NaN for parts
    that are not.
    """
    if answer.layout is not None:
        return answer.layout.half_sizes
    seen = (answer.on_part(part)[0] for part in range(len(answer.part_scales)))
    return np.array([np.abs(npcs - MIDDLE).max(axis=0) if len(npcs) else np.full(3, np.nan) for npcs in seen])


def telling(answer: PointAnswers, joint: int) -> NDArray[np.bool_]:
    """The points [n] that tell of a joint (from 1); where none does, those of the part that it moves."""
    own = answer.joints == joint
    return np.asarray(own if own.any() else answer.parts == joint)


def said_joints(answer: PointAnswers, structure: Structure) -> tuple[F64, F64]:
    """Directions (unit) and pivots [K - 1, 3] in NAOCS.

    The medians over the points that are `telling` of a joint; NaN where there is none. Pivots are those of the layout, where
    there is one.
    """
    directions, pivots = (np.full((structure.part_count - 1, 3), np.nan) for _ in range(2))
    for joint in range(1, structure.part_count):
        own = telling(answer, joint)
        if own.any():
            direction = np.median(answer.axes[own], axis=0)
            length = float(np.linalg.norm(direction))
            directions[joint - 1] = direction / length if length > LEAST_LENGTH else np.nan
            pivots[joint - 1] = np.median(answer.pivots[own], axis=0)
    if answer.layout is not None:
        pivots = answer.layout.pivots
    return directions, pivots
