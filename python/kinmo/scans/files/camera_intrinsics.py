"""Intrinsics of a depth camera, as users give them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError


@dataclass(frozen=True)
class Intrinsics:
    """Focal lengths and principal point in pixels; the middle of the first pixel is (0, 0)."""

    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def parse(cls, text: str) -> Intrinsics:
        """Read `fx,fy,cx,cy` from the command line; InputError if the text has another form."""
        try:
            return cls._checked([float(value) for value in text.split(",")])
        except ValueError:
            problem = f"expected fx,fy,cx,cy in pixels, fx and fy above 0, got {text!r}"
            raise InputError("--intrinsics", problem) from None

    @classmethod
    def from_matrix(cls, matrix: NDArray[np.generic], source: Path) -> Intrinsics:
        """Read [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] or (fx, fy, cx, cy) from a file; InputError for any other array."""
        values = np.asarray(matrix, np.float64)
        if values.shape == (3, 3):
            fx, fy, cx, cy = numbers = values[[0, 1, 0, 1], [0, 1, 2, 2]]
            is_matrix = np.allclose(values, [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]], rtol=0.0, atol=1e-6)
            values = numbers if is_matrix else np.zeros(0)
        try:
            return cls._checked(values.tolist() if values.ndim == 1 else [])
        except ValueError:
            problem = "expected the matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], or fx, fy, cx, cy"
            raise InputError(source, problem, "intrinsics") from None

    @classmethod
    def _checked(cls, values: list[float]) -> Intrinsics:
        if len(values) != 4 or not np.isfinite(values).all() or min(values[:2]) <= 0.0:
            raise ValueError(values)
        return cls(*values)
