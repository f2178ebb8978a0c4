"""Labels of the faces of a shape from a file: the output of a segmentation tool."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes


def read_labels(path: Path, faces: int, shape: Path) -> NDArray[np.int64]:
    """Labels [F] of the faces of a shape from an .npy file, numbered from 0 in ascending order. Raises InputError."""
    import io

    raw = read_bytes(path, path.parent, MAX_SCENE_BYTES)
    try:
        found = np.load(io.BytesIO(raw), allow_pickle=False)
    except Exception as error:  # NumPy raises many kinds of errors for broken files
        raise InputError(path, f"expected an .npy file with one integer per triangle ({type(error).__name__})") from None
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "iu" or found.size != faces or found.ndim > 2:
        got = f"{list(found.shape)} of {found.dtype}" if isinstance(found, np.ndarray) else "several arrays"
        problem = f"expected {faces} integers, one per triangle of {shape.name} in the order of the file, got {got}"
        raise InputError(path, problem)
    values, labels = np.unique(found, return_inverse=True)
    if len(values) < 2:
        raise InputError(path, "expected at least two labels: every triangle has the same one, so there is one part")
    return np.asarray(labels.ravel(), np.int64)
