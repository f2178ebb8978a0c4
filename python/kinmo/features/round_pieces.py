"""Round pieces of a shape, such as the pins, barrels and axles that joints are built from.

Boxes and contact miss the axis of many hinges. The screw of a pair of scissors lies on no box edge of a blade, and closed
blades touch along their whole length. A round piece often lies exactly on the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]

MAX_PIECES = 8
"""Largest number of round pieces kept per group, and of its neighbours."""


@dataclass(frozen=True, eq=False)
class RoundPieces:
    """K connected pieces of mesh that are round about a line, in the normalised frame.

    Attributes:
        leaves ([K]): Position of the leaf that each piece belongs to.
        middles ([K, 3]): Middle of each piece, on its line.
        directions ([K, 3]): Unit vectors along the lines.
        radii ([K]): Largest distance of a piece from its line.
        half_lengths ([K]): Half the length of each piece along its line.
    """

    leaves: NDArray[np.int64]
    middles: F64
    directions: F64
    radii: F64
    half_lengths: F64

    @classmethod
    def of(cls, meshes: _core.Meshes) -> RoundPieces:
        """Round pieces of all leaves."""
        leaves, *rest = _core.find_round_pieces(meshes)
        return cls(leaves.astype(np.int64), *rest)

    def __len__(self) -> int:
        return len(self.leaves)

    def subset(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> RoundPieces:
        """The pieces at a mask or at indices."""
        return RoundPieces(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def lines(self) -> F64:
        """Lines of the pieces as (point, direction) [K, 2, 3]."""
        return np.stack([self.middles, self.directions], axis=1)

    @property
    def reaches(self) -> F64:
        """Largest distance [K] of a point of each piece from its middle."""
        return np.asarray(np.hypot(self.radii, self.half_lengths))

    def nearest_to(self, point: F64) -> RoundPieces:
        """The pieces, `MAX_PIECES` or fewer, whose lines pass nearest to `point` [3]."""
        if not len(self):
            return self
        distances = np.linalg.norm(np.cross(point - self.middles, self.directions), axis=1)
        return self.subset(np.sort(np.argsort(distances, kind="stable")[:MAX_PIECES]))


def joint_pieces(
    pieces: RoundPieces, meshes: _core.Meshes, group: Sequence[int], touched: NDArray[np.bool_], near: float, contact: F64
) -> tuple[RoundPieces, RoundPieces]:
    """Round pieces that a group of leaves may turn about: its own, and those of the leaves that it touches ([L] bool).

    A piece of a touched leaf is at most `near` from the group. Of both, the pieces nearest to the middle `contact` [3] of the
    group's contact region are kept.
    """
    if not len(pieces):
        return pieces, pieces
    own = np.isin(pieces.leaves, group)
    others = pieces.subset(~own & touched[pieces.leaves])
    if len(others):
        distances = _core.closest_points(meshes, list(group), others.middles)[0]
        others = others.subset(distances <= others.reaches + near)
    return pieces.subset(own).nearest_to(contact), others.nearest_to(contact)
