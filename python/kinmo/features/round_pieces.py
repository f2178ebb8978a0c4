"""Round pieces of a shape, such as the pins, barrels and axles that joints are made with.

Boxes and contact miss the line of many a hinge: the screw of a pair of scissors is no edge of a blade, and closed blades touch
all along. The piece that makes the joint is often there, round about the very line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]

MOST = 8
"""Of a part's own round pieces, and of those of its neighbours: those nearest to its contact."""


@dataclass(frozen=True, eq=False)
class RoundPieces:
    """K pieces in the normalised frame: the leaf [K] each is of, its `middles` [K, 3] on its line, the line's unit `directions`
    [K, 3], and how far it reaches from the line (`radii` [K]) and from the middle along it (`half_lengths` [K]).
    """

    leaves: NDArray[np.int64]
    middles: F64
    directions: F64
    radii: F64
    half_lengths: F64

    @classmethod
    def of(cls, meshes: _core.Meshes) -> RoundPieces:
        """Those of all leaves."""
        leaves, *rest = _core.find_round_pieces(meshes)
        return cls(leaves.astype(np.int64), *rest)

    def __len__(self) -> int:
        return len(self.leaves)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> RoundPieces:
        """Some of them."""
        return RoundPieces(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def lines(self) -> F64:
        """(point, direction) [K, 2, 3]."""
        return np.stack([self.middles, self.directions], axis=1)

    @property
    def reaches(self) -> F64:
        """How far [K] any point of a piece may be from its middle."""
        reaches: F64 = np.hypot(self.radii, self.half_lengths)
        return reaches

    def nearest_to(self, point: F64) -> RoundPieces:
        """The `MOST` whose lines pass nearest to a point [3]."""
        distances = np.linalg.norm(np.cross(point - self.middles, self.directions), axis=1)
        return self.where(np.sort(np.argsort(distances, kind="stable")[:MOST]))


def round_pieces_of(
    pieces: RoundPieces, meshes: _core.Meshes, leaves: Sequence[int], touching: NDArray[np.bool_], near: float, contact: F64
) -> tuple[RoundPieces, RoundPieces]:
    """The part's own round pieces, and those of the leaves that it touches (`touching` [L] bool) nearer to it than `near`.

    Of many, those are taken whose lines pass nearest to the middle of the `contact` [3].
    """
    own = np.isin(pieces.leaves, leaves)
    others = pieces.where(~own & touching[pieces.leaves])
    if len(others):
        distances = _core.closest_points(meshes, list(leaves), others.middles)[0]
        others = others.where(distances <= others.reaches + near)
    return pieces.where(own).nearest_to(contact), others.nearest_to(contact)
