"""Candidate axes of one part, as undirected lines: from its boxes, its contact with other parts, and round geometry.

The lines turn with the object. The only outside direction is `up`; horizontal directions are the object's own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from kinmo.core.oriented_box import Box

F64 = NDArray[np.float64]

SAME_DIRECTION = np.cos(np.radians(0.5))
"""Cosine above which two lines are parallel (0.5 degrees)."""
SAME_LINE = 0.004
"""Distance, in diagonals at the part, below which parallel lines are one candidate."""

SIGNS = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [0.0, 0.0]])
"""Places of the lines of a box along one of its axes, in half extents: four edges and the centre line."""


class LineSource(IntEnum):
    """Geometry that a candidate axis comes from; the values index the columns of `CandidateLines.sources`."""

    MINIMUM_BOX_EDGE = 0
    MINIMUM_BOX_CENTER = 1
    ALIGNED_BOX_EDGE = 2
    ALIGNED_BOX_CENTER = 3
    CONTACT_LINE = 4
    CONTACT_CENTER = 5
    OWN_ROUND_PIECE = 6
    NEIGHBOUR_ROUND_PIECE = 7
    SYMMETRY_AXIS = 8


CENTRAL_SOURCES = (
    LineSource.MINIMUM_BOX_CENTER,
    LineSource.ALIGNED_BOX_CENTER,
    LineSource.CONTACT_CENTER,
    LineSource.SYMMETRY_AXIS,
)
"""Sources of the axes that a screw joint may have."""


@dataclass(frozen=True, eq=False)
class CandidateLines:
    """K undirected lines.

    Attributes:
        directions ([K, 3]): Unit vectors.
        pivots ([K, 3]): Points of the lines nearest to the part's centre.
        sources ([K, 9] bool): One column per `LineSource`; merged lines have several sources.
    """

    directions: F64
    pivots: F64
    sources: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.directions)


def box_lines(box: Box) -> tuple[F64, F64, NDArray[np.bool_]]:
    """The 12 edges and 3 centre lines of a box: unit directions [15, 3], pivots [15, 3], and a mask [15] of the edges.

    Pivots are midpoints of the edges, and the box centre.
    """
    offsets = []
    for first, second in ((1, 2), (0, 2), (0, 1)):
        along = (SIGNS * box.half_extents[[first, second]])[:, :, None] * box.axes[[first, second]]
        offsets.append(along[:, 0] + along[:, 1])
    is_edge = np.tile(SIGNS.any(axis=1), 3)
    return np.repeat(box.axes, len(SIGNS), axis=0), box.center + np.concatenate(offsets), is_edge


def merge_lines(directions: F64, pivots: F64, sources: NDArray[np.int64], center: F64) -> CandidateLines:
    """Merge near-equal lines (unit directions [K, 3], pivots [K, 3], sources [K]): keep the first of each set.

    It gets the sources of all. Pivots move along their lines to the points nearest to the part's centre.
    """
    pivots = pivots + np.sum((center - pivots) * directions, axis=1, keepdims=True) * directions
    parallel = np.abs(directions @ directions.T) > SAME_DIRECTION
    close = np.linalg.norm(pivots[:, None] - pivots[None], axis=-1) < SAME_LINE
    same = parallel & close
    one_hot = np.eye(len(LineSource), dtype=bool)[sources]
    kept: list[int] = []
    merged = np.zeros(len(directions), bool)
    for index in range(len(directions)):
        if not merged[index]:
            kept.append(index)
            one_hot[index] = one_hot[same[index] & ~merged].any(axis=0)
            merged |= same[index]
    return CandidateLines(directions[kept], pivots[kept], one_hot[kept])


def candidate_lines(
    minimum: Box, aligned: Box, contact_points: F64, contact_weights: F64, others: Mapping[LineSource, F64]
) -> CandidateLines:
    """All candidate axes of a part, near-equal ones merged.

    They come from its minimum-volume and its aligned box, its contact points [M, 3] with weights [M], and `others`: further
    lines by source, [S, 2, 3] pairs of (point, direction).
    """
    directions, pivots, sources = [], [], []
    for box, edge, middle in (
        (minimum, LineSource.MINIMUM_BOX_EDGE, LineSource.MINIMUM_BOX_CENTER),
        (aligned, LineSource.ALIGNED_BOX_EDGE, LineSource.ALIGNED_BOX_CENTER),
    ):
        box_directions, box_pivots, is_edge = box_lines(box)
        directions.append(box_directions)
        pivots.append(box_pivots)
        sources += [edge if e else middle for e in is_edge]
    centroid = np.average(contact_points, axis=0, weights=contact_weights)
    spread = (contact_points - centroid).T * contact_weights @ (contact_points - centroid)
    principal = np.linalg.eigh(spread)[1][:, -1]
    directions += [principal[None], aligned.axes, minimum.axes]
    pivots += [centroid[None], np.repeat(centroid[None], 6, axis=0)]
    sources += [LineSource.CONTACT_LINE] + [LineSource.CONTACT_CENTER] * 6
    for source, lines in others.items():
        directions.append(lines[:, 1])
        pivots.append(lines[:, 0])
        sources += [source] * len(lines)
    return merge_lines(np.concatenate(directions), np.concatenate(pivots), np.array(sources), aligned.center)


def distinct_directions(lines: CandidateLines) -> NDArray[np.int64]:
    """Indices of lines with pairwise distinct directions; the first of each direction is kept."""
    parallel = np.abs(lines.directions @ lines.directions.T) > SAME_DIRECTION
    kept: list[int] = []
    for index in range(len(lines)):
        if not parallel[index, kept].any():
            kept.append(index)
    return np.array(kept, np.int64)
