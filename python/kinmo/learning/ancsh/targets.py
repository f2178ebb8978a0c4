"""What ANCSH is to say about a scan: canonical coordinates and the surroundings of joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.joint import Joint
from kinmo.scans.articulated_object import Extents, Structure

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

REACH = 0.2
"""Distance from a joint's axis, in diagonals, within which points tell of it."""


LEAST_SIZE = 1e-3
"""Of half the side of a part's box in NPCS: what is flat has sides that no ratio tells."""


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Of n points: `joints` [n] (0: none near), `heatmap` [n], `toward` and `axes` [n, 3] in NAOCS, `has_pivot` [n]."""

    joints: NDArray[np.int64]
    heatmap: F32
    toward: F32
    axes: F32
    has_pivot: NDArray[np.bool_]


def canonical_coordinates(places: NDArray[np.floating], parts: NDArray[np.integer], extents: Extents) -> tuple[F32, F32]:
    """NPCS and NAOCS [n, 3] of `places` [n, 3] of the normalised frame on `parts` [n] (below 0: none).

    Of the object in NAOCS, as of every part in NPCS, the axis-aligned box has its middle at (0.5, 0.5, 0.5) and the diagonal 1.
    """
    own = np.maximum(parts, 0)
    npcs = (places - extents.centers[own]) / extents.diagonals[own, None] + 0.5
    return npcs.astype(np.float32), np.asarray(places + 0.5, np.float32)


def surroundings(
    places: NDArray[np.floating],
    parts: NDArray[np.integer],
    joints: Sequence[Joint],
    structure: Structure,
    *,
    nearest: bool = True,
    lines_only: bool = False,
) -> Surroundings:
    """Which joint every point is near to, and where its axis lies from there.

    A joint with a pivot is told of by points of the part that it moves and of the one that this moves against, within `REACH`
    of its axis; one without by all points of the part that it moves. Near to several, a point tells of the `nearest`, else, as
    in the release, of the last. With `lines_only`, as there too, a joint without a pivot is one about its stored origin.
    """
    count = len(places)
    found = Surroundings(
        np.zeros(count, np.int64),
        np.zeros(count, np.float32),
        np.zeros((count, 3), np.float32),
        np.zeros((count, 3), np.float32),
        np.zeros(count, bool),
    )
    closest = np.full(count, np.inf)
    for number, (joint, parent) in enumerate(zip(joints, structure.parents, strict=True), start=1):
        is_line = joint.has_pivot or lines_only
        if is_line:
            offsets = joint.pivot - places
            offsets = offsets - (offsets @ joint.direction)[:, None] * joint.direction
            distances = np.linalg.norm(offsets, axis=1)
            near = ((parts == number) | (parts == parent)) & (distances < REACH)
        else:
            offsets, distances = np.zeros((count, 3)), np.full(count, REACH)
            near = parts == number
        if nearest:
            near &= distances < closest
        closest[near] = distances[near]
        found.joints[near] = number
        found.heatmap[near] = 1.0 - distances[near] / REACH
        found.toward[near] = offsets[near] / np.maximum(distances[near, None], 1e-9)
        found.axes[near] = joint.direction
        found.has_pivot[near] = is_line
    return found


def layout(extents: Extents, joints: Sequence[Joint]) -> tuple[F32, F32, NDArray[np.bool_]]:
    """Half of the sides [K, 3] of the parts' boxes in NPCS; pivots [K - 1, 3] in NAOCS, those next to the middles of the parts
    that move; and whether a joint has one [K - 1].
    """
    half_sizes = np.maximum(0.5 * extents.sizes / extents.diagonals[:, None], LEAST_SIZE)
    directions, pivots = (np.array([getattr(joint, name) for joint in joints]) for name in ("direction", "pivot"))
    along = np.sum((extents.centers[1:] - pivots) * directions, axis=1, keepdims=True)
    nearest = pivots + along * directions + 0.5
    return half_sizes.astype(np.float32), nearest.astype(np.float32), np.array([joint.has_pivot for joint in joints])
