"""What ANCSH is to say about a scan: canonical coordinates and the surroundings of joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.scans.articulated_object import Extents, Structure

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

REACH = 0.2
"""Distance from a joint's axis, in diagonals, within which points tell of it."""


LEAST_SIZE = 1e-3
"""Of half the side of a part's box in NPCS: what is flat has sides that no ratio tells."""


@dataclass(frozen=True, eq=False)
class JointAxes:
    """Those of J joints of B objects: `directions` and `pivots` [B, J, 3] in the normalised frame; `has_pivot` [B, J]."""

    directions: F64
    pivots: F64
    has_pivot: NDArray[np.bool_]

    @classmethod
    def of(cls, joints: Sequence[Sequence[Joint]]) -> JointAxes:
        """For the joints of each object."""
        directions, pivots, has_pivot = (
            np.array([[getattr(joint, name) for joint in each] for each in joints])
            for name in ("direction", "pivot", "has_pivot")
        )
        return cls(directions, pivots, has_pivot)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Of n points of B scans: `joints` [B, n] (0: none near), `heatmap` [B, n], `toward` and `axes` [B, n, 3] in NAOCS,
    `has_pivot` [B, n].
    """

    joints: NDArray[np.int64]
    heatmap: F32
    toward: F32
    axes: F32
    has_pivot: NDArray[np.bool_]


def canonical_coordinates(places: NDArray[np.floating], parts: NDArray[np.integer], extents: Extents) -> tuple[F32, F32]:
    """NPCS and NAOCS [..., n, 3] of `places` [..., n, 3] of the normalised frame on `parts` [..., n] (below 0: none) with these
    `extents` [..., K].

    Of the object in NAOCS, as of every part in NPCS, the axis-aligned box has its middle at (0.5, 0.5, 0.5) and the diagonal 1.
    """
    own = np.maximum(parts, 0)[..., None]
    centers, diagonals = (np.take_along_axis(each, own, -2) for each in (extents.centers, extents.diagonals[..., None]))
    return ((places - centers) / diagonals + 0.5).astype(np.float32), np.asarray(places + 0.5, np.float32)


def surroundings(
    places: NDArray[np.floating],
    parts: NDArray[np.integer],
    axes: JointAxes,
    structure: Structure,
    *,
    nearest: bool = True,
    lines_only: bool = False,
) -> Surroundings:
    """Which joint every point of B scans is near to, and where its axis lies from there: of `places` [B, n, 3] of the
    normalised frame on `parts` [B, n].

    A joint with a pivot is told of by points of the part that it moves and of the one that this moves against, within `REACH`
    of its axis; one without by all points of the part that it moves. Near to several, a point tells of the `nearest`, else, as
    in the release, of the last. With `lines_only`, as there too, a joint without a pivot is one about its stored origin.
    """
    is_line = axes.has_pivot | lines_only
    offsets, directions = axes.pivots[:, :, None] - places[:, None], axes.directions[:, :, None]
    offsets -= np.einsum("bjnk,bjok->bjn", offsets, directions)[..., None] * directions
    distances = np.linalg.norm(offsets, axis=-1)
    moved, parents = np.arange(1, len(structure.parents) + 1)[:, None], np.array(structure.parents)[:, None]
    is_moved, is_parent = parts[:, None] == moved, parts[:, None] == parents
    near = np.where(is_line[..., None], (is_moved | is_parent) & (distances < REACH), is_moved)  # [B, J, n]
    distances = np.where(is_line[..., None], distances, REACH)
    if nearest:
        chosen = np.where(near, distances, np.inf).argmin(axis=1)
    else:
        chosen = len(structure.parents) - 1 - near[:, ::-1].argmax(axis=1)
    scans, points = np.arange(len(places))[:, None], np.arange(places.shape[1])
    distances, offsets = distances[scans, chosen, points], offsets[scans, chosen, points]
    is_near = near.any(axis=1)
    placed = is_near & is_line[scans, chosen]
    return Surroundings(
        np.where(is_near, chosen + 1, 0),
        np.where(placed, 1.0 - distances / REACH, 0.0).astype(np.float32),
        np.where(placed[..., None], offsets / np.maximum(distances, 1e-9)[..., None], 0.0).astype(np.float32),
        np.where(is_near[..., None], axes.directions[scans, chosen], 0.0).astype(np.float32),
        placed,
    )


def layout(extents: Extents, axes: JointAxes) -> tuple[F32, F32]:
    """Half of the sides [B, K, 3] of the parts' boxes in NPCS, and pivots [B, K - 1, 3] in NAOCS: those next to the middles of
    the parts that move. Of B objects with `extents` [B, K].
    """
    half_sizes = np.maximum(0.5 * extents.sizes / extents.diagonals[..., None], LEAST_SIZE)
    along = np.sum((extents.centers[:, 1:] - axes.pivots) * axes.directions, axis=-1, keepdims=True)
    return half_sizes.astype(np.float32), (axes.pivots + along * axes.directions + 0.5).astype(np.float32)
