"""Every motion that one part might have: axes from its boxes, its contact with the rest, and what is round about a line.

The `kinmo` method decides kind and axis of a joint together, as one choice among these. Nothing here depends on how the object
is turned: the only outside directions are `up` and the object's own horizontal axes (`object_frame`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from kinmo.core.box import Box

F64 = NDArray[np.float64]

SAME_DIRECTION = np.cos(np.radians(0.5))
SAME_LINE = 0.004
"""Two lines closer than this (in diagonals) at the part, and as parallel as SAME_DIRECTION, are one candidate."""


class Source(IntEnum):
    """Where a candidate axis comes from."""

    MINIMUM_BOX_EDGE = 0
    MINIMUM_BOX_CENTER = 1
    ALIGNED_BOX_EDGE = 2
    ALIGNED_BOX_CENTER = 3
    CONTACT_LINE = 4
    CONTACT_CENTER = 5
    OWN_ROUND_PIECE = 6
    NEXT_ROUND_PIECE = 7
    SYMMETRY_AXIS = 8


CENTRAL = (Source.MINIMUM_BOX_CENTER, Source.ALIGNED_BOX_CENTER, Source.CONTACT_CENTER, Source.SYMMETRY_AXIS)
"""Sources of the axes about which a part may screw."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Undirected lines: unit `directions` [K, 3], `pivots` [K, 3] (nearest to the part's centre), `sources` [K, 9] bool."""

    directions: F64
    pivots: F64
    sources: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.directions)


def object_frame(normals: F64, weights: F64, up: F64) -> F64:
    """The object's own axes [3, 3], rows: two horizontal ones and `up`.

    The horizontal axes are the directions that most surface faces, counted modulo quarter turns, so that they turn with the
    object. `normals` [N, 3] with `weights` [N] (areas).
    """
    east = np.cross(up, [0.0, 0.0, 1.0] if abs(up[2]) < 0.9 else [1.0, 0.0, 0.0])
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    x, y = normals @ east, normals @ north
    flatness = x * x + y * y
    angle = np.arctan2(y, x)
    mass = weights * flatness * flatness
    turn = np.angle(np.sum(mass * np.exp(4j * angle))) / 4.0
    # The mean is pulled by round surfaces; the median of what lies close to it is the flat faces' own direction.
    offset = np.angle(np.exp(4j * (angle - turn))) / 4.0
    near = np.abs(offset) < np.radians(6.0)
    if np.any(near & (mass > 0)):
        order = np.argsort(offset[near])
        cumulative = np.cumsum(mass[near][order])
        turn += offset[near][order][np.searchsorted(cumulative, 0.5 * cumulative[-1])]
    first = np.cos(turn) * east + np.sin(turn) * north
    return np.stack([first, np.cross(up, first), up])


def box_lines(box: Box) -> tuple[F64, F64, NDArray[np.bool_]]:
    """Directions [15, 3] and pivots [15, 3] of the 12 edges and 3 centre lines of a box, and which are edges [15]."""
    directions, pivots, is_edge = [], [], []
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        for signs in ((-1, -1), (-1, 1), (1, -1), (1, 1), (0, 0)):
            offset = sum(s * box.half_extents[i] * box.axes[i] for s, i in zip(signs, others, strict=True))
            directions.append(box.axes[axis])
            pivots.append(box.center + offset)
            is_edge.append(signs != (0, 0))
    return np.array(directions), np.array(pivots), np.array(is_edge)


def merge_lines(directions: F64, pivots: F64, sources: NDArray[np.int64], center: F64) -> Lines:
    """Lines [K, 3] with the near-equal ones made one; the first of equals is kept, with the sources of all."""
    pivots = pivots + np.sum((center - pivots) * directions, axis=1, keepdims=True) * directions
    parallel = np.abs(directions @ directions.T) > SAME_DIRECTION
    close = np.linalg.norm(pivots[:, None] - pivots[None], axis=-1) < SAME_LINE
    same = parallel & close
    hot = np.eye(len(Source), dtype=bool)[sources]
    kept: list[int] = []
    taken = np.zeros(len(directions), bool)
    for index in range(len(directions)):
        if not taken[index]:
            kept.append(index)
            hot[index] = hot[same[index] & ~taken].any(axis=0)
            taken |= same[index]
    return Lines(directions[kept], pivots[kept], hot[kept])


def candidate_lines(
    minimum: Box, aligned: Box, contact_points: F64, contact_weights: F64, others: Mapping[Source, F64] | None = None
) -> Lines:
    """All candidate axes of a part.

    `minimum` is its minimum-volume box and `aligned` its box along the object's own frame; `contact_points` [M, 3] with weights
    [M] lie on the part where it comes closest to the rest; `others` [S, 2, 3] are (point, direction), by where they come from.
    """
    directions, pivots, sources = [], [], []
    for box, edge, middle in (
        (minimum, Source.MINIMUM_BOX_EDGE, Source.MINIMUM_BOX_CENTER),
        (aligned, Source.ALIGNED_BOX_EDGE, Source.ALIGNED_BOX_CENTER),
    ):
        d, p, is_edge = box_lines(box)
        directions.append(d)
        pivots.append(p)
        sources += [edge if e else middle for e in is_edge]
    centroid = np.average(contact_points, axis=0, weights=contact_weights)
    spread = (contact_points - centroid).T * contact_weights @ (contact_points - centroid)
    principal = np.linalg.eigh(spread)[1][:, -1]
    directions += [principal[None], aligned.axes, minimum.axes]
    pivots += [centroid[None], np.repeat(centroid[None], 6, axis=0)]
    sources += [Source.CONTACT_LINE] + [Source.CONTACT_CENTER] * 6
    for source, axes in (others or {}).items():
        directions.append(axes[:, 1])
        pivots.append(axes[:, 0])
        sources += [source] * len(axes)
    return merge_lines(np.concatenate(directions), np.concatenate(pivots), np.array(sources), aligned.center)


def distinct_directions(lines: Lines) -> NDArray[np.int64]:
    """Indices of lines with pairwise distinct directions, first come first kept."""
    parallel = np.abs(lines.directions @ lines.directions.T) > SAME_DIRECTION
    kept: list[int] = []
    for index in range(len(lines)):
        if not parallel[index, kept].any():
            kept.append(index)
    return np.array(kept, np.int64)
