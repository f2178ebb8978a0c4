"""Training targets of ANCSH: canonical coordinates, joints near points, and box sizes (Li et al. 2020, section 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint
from kinmo.scans.object_structure import Extents, Structure

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

JOINT_RADIUS = 0.2
"""Distance from a joint axis, in diagonals of the object, within which points predict the joint."""
MIN_HALF_SIZE = 1e-3
"""Least half side of a part's box in NPCS. A flat part has a side of zero, and ratios to zero are meaningless."""


@dataclass(frozen=True, eq=False)
class JointAxes:
    """Axes of the J joints of each of B objects in the normalised frame: unit directions and pivots [B, J, 3].

    `has_pivot` [B, J] is False for sliders, whose axes have no place.
    """

    directions: F64
    pivots: F64
    has_pivot: NDArray[np.bool_]

    @classmethod
    def of(cls, joints: Sequence[Sequence[Joint]]) -> JointAxes:
        """Axes of the joints of several objects with as many joints each."""
        directions, pivots, has_pivot = (
            np.array([[getattr(joint, name) for joint in each] for each in joints])
            for name in ("direction", "pivot", "has_pivot")
        )
        return cls(directions, pivots, has_pivot)


class JointTargets(NamedTuple):
    """Joint near each of n points in B scans, as in `ancsh_loss.ScanBatch`. The heatmap is 0 at `JOINT_RADIUS`."""

    joints: NDArray[np.int64]
    heatmap: F32
    toward: F32
    axes: F32
    has_pivot: NDArray[np.bool_]


def canonical_coordinates(points: NDArray[np.floating], parts: NDArray[np.integer], extents: Extents) -> tuple[F32, F32]:
    """NPCS and NAOCS of points on an object in its canonical pose (Li et al. 2020, section 4).

    The axis-aligned box of a part in NPCS, and that of the object in NAOCS, has its middle at (0.5, 0.5, 0.5) and a diagonal
    of 1. Points [..., n, 3] are in the normalised frame. Negative parts [..., n] are none, and count as part 0.
    """
    own = np.maximum(parts, 0)[..., None]
    centers, diagonals = (np.take_along_axis(each, own, -2) for each in (extents.centers, extents.diagonals[..., None]))
    return ((points - centers) / diagonals + 0.5).astype(np.float32), np.asarray(points + 0.5, np.float32)


def joint_targets(
    points: NDArray[np.floating], parts: NDArray[np.integer], axes: JointAxes, structure: Structure, like_release: bool = False
) -> JointTargets:
    """Joint near every point, and the position of its axis relative to the point (Li et al. 2020, section 4).

    A joint with a pivot is near the points of its moving part and of that part's parent within `JOINT_RADIUS` of the axis. A
    joint without one is near all points of its moving part. A point near several joints gets the nearest. The release takes
    the last of them, and treats every axis as a line through its stored origin. Points [B, n, 3] are in the normalised frame.
    """
    is_line = axes.has_pivot | like_release
    offsets, directions = axes.pivots[:, :, None] - points[:, None], axes.directions[:, :, None]
    offsets -= np.einsum("bjnk,bjok->bjn", offsets, directions)[..., None] * directions
    distances = np.linalg.norm(offsets, axis=-1)
    moved, parents = np.arange(1, len(structure.parents) + 1)[:, None], np.array(structure.parents)[:, None]
    is_moved, is_parent = parts[:, None] == moved, parts[:, None] == parents
    near = np.where(is_line[..., None], (is_moved | is_parent) & (distances < JOINT_RADIUS), is_moved)  # [B, J, n]
    distances = np.where(is_line[..., None], distances, JOINT_RADIUS)
    if like_release:
        chosen = len(structure.parents) - 1 - near[:, ::-1].argmax(axis=1)
    else:
        chosen = np.where(near, distances, np.inf).argmin(axis=1)
    scans, columns = np.arange(len(points))[:, None], np.arange(points.shape[1])
    distances, offsets = distances[scans, chosen, columns], offsets[scans, chosen, columns]
    is_near = near.any(axis=1)
    near_line = is_near & is_line[scans, chosen]
    return JointTargets(
        np.where(is_near, chosen + 1, 0),
        np.where(near_line, 1.0 - distances / JOINT_RADIUS, 0.0).astype(np.float32),
        np.where(near_line[..., None], offsets / np.maximum(distances, 1e-9)[..., None], 0.0).astype(np.float32),
        np.where(is_near[..., None], axes.directions[scans, chosen], 0.0).astype(np.float32),
        near_line,
    )


def global_targets(extents: Extents, axes: JointAxes) -> tuple[F32, F32]:
    """Targets of the global head: half sides of the parts' boxes in NPCS [B, K, 3], and pivots in NAOCS [B, K - 1, 3].

    The pivots are the points of the axes that are nearest to the middles of the moving parts.
    """
    half_sizes = np.maximum(0.5 * extents.sizes / extents.diagonals[..., None], MIN_HALF_SIZE)
    along = np.sum((extents.centers[:, 1:] - axes.pivots) * axes.directions, axis=-1, keepdims=True)
    return half_sizes.astype(np.float32), (axes.pivots + along * axes.directions + 0.5).astype(np.float32)
