"""Prepared objects with random rotations, to measure results without the pose of the files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from kinmo.dataset.store import read_prepared, to_bytes
from kinmo.features.prepared_shape import PreparedShape
from kinmo.features.shape_preparation import prepare_shape
from kinmo.io.discover import ShapeSource


def turned_shapes(shapes: Sequence[PreparedShape], folder: Path, *, freely: bool) -> list[PreparedShape]:
    """All shapes with random rotations, about `up` or free (`up` rotates along). They are kept in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for shape in shapes:
        path = folder / f"{shape.id}.safetensors"
        if not path.exists():
            rng = np.random.default_rng(list(shape.id.encode()))
            about_up = Rotation.from_rotvec(shape.up * rng.uniform(-np.pi, np.pi))
            turn = (Rotation.random(rng=rng) if freely else about_up).as_matrix()
            source = ShapeSource.of(shape).read()
            path.write_bytes(to_bytes(prepare_shape(source.rotated(turn))))
        found.append(read_prepared(path))
    return found
