"""How scans come to networks, whatever their place and size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

Normalised = Literal["object", "scan"]
"""Whose size and place a scan is brought to: the object's true diagonal, its place kept; or the visible points' own."""


@dataclass(frozen=True, eq=False)
class InputFrame:
    """How points come to a network: (camera - `center`) * `scale`."""

    center: F64
    scale: float

    @classmethod
    def of(cls, points: NDArray[np.floating], normalised: Normalised, diagonal: float = 1.0) -> InputFrame:
        """For the points [n, 3] of a scan of an object with this `diagonal`, which only `object` looks at."""
        if normalised == "object":
            return cls(np.zeros(3), 1.0 / diagonal)
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(0.5 * (low + high).astype(np.float64), 1.0 / max(float(np.linalg.norm(high - low)), 1e-9))

    def apply(self, points: NDArray[np.floating]) -> F32:
        return np.asarray((points - self.center) * self.scale, np.float32)

    def undo(self, points: F64) -> F64:
        """Points [..., 3] that networks see, in the camera's frame."""
        return points / self.scale + self.center
