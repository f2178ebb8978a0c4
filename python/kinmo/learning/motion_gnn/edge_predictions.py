"""Predictions of the motion GNN for the edges of one shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinmo.core.motion_types import CoarseType, MotionType


@dataclass(frozen=True, eq=False)
class EdgePredictions:
    """Prediction for each of the E edges of a PreparedShape. All arrays are float64.

    Attributes:
        type_probabilities: Probabilities [E, 10] over MotionType, or [E, 5] over CoarseType.
        directions: Unit axis directions [E, 3]. Meaningful only where the type is a motion.
        pivots: Points on the axes [E, 3] in the normalised frame. Meaningful only where the type is a motion.
    """

    type_probabilities: NDArray[np.float64]
    directions: NDArray[np.float64]
    pivots: NDArray[np.float64]

    @property
    def type_set(self) -> type[MotionType] | type[CoarseType]:
        """Enumeration that the columns of `type_probabilities` stand for."""
        return MotionType if self.type_probabilities.shape[1] == len(MotionType) else CoarseType

    @property
    def types(self) -> NDArray[np.int64]:
        """Most probable type [E], as values of `type_set`."""
        return np.asarray(np.argmax(self.type_probabilities, axis=1), np.int64)
