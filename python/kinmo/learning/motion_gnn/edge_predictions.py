"""What the motion GNN says of the edges of one shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import CoarseType, MotionType


@dataclass(frozen=True, eq=False)
class EdgePredictions:
    """One answer for each of the E edges of a PreparedShape.

    `type_probabilities` [E, 10] over MotionType, or [E, 5] over CoarseType; `directions` [E, 3] unit vectors and `pivots` [E,
    3] in the normalised frame, to be heeded only where the type is a motion; all float64.
    """

    type_probabilities: NDArray[np.float64]
    directions: NDArray[np.float64]
    pivots: NDArray[np.float64]

    @property
    def type_set(self) -> type[MotionType] | type[CoarseType]:
        return MotionType if self.type_probabilities.shape[1] == len(MotionType) else CoarseType

    @property
    def types(self) -> NDArray[np.int64]:
        """The most probable type [E], a value of `type_set`."""
        return np.asarray(np.argmax(self.type_probabilities, axis=1), np.int64)
