"""What a direction, a place or an axis is an array of."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""[3], float64."""
