"""Prepared objects in another pose, so that what is measured is not the pose of the files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo.formats import Found, Layout, read_found
from kinmo.joint import Joint
from kinmo.mobility import Mobility
from kinmo.prepare import prepare_shape
from kinmo.prepare.shape import seed_of
from kinmo.prepared import PreparedShape
from kinmo.shape import Mesh, Shape
from kinmo.store import read_prepared, to_bytes


def turned(shape: Shape, turn: NDArray[np.float64]) -> Shape:
    """`shape` turned about the origin: meshes, joints and `up`."""

    def joint(old: Joint | None) -> Joint | None:
        return None if old is None else replace(old, direction=turn @ old.direction, pivot=turn @ old.pivot)

    def mesh(old: Mesh | None) -> Mesh | None:
        return None if old is None else Mesh(np.ascontiguousarray(old.vertices @ turn.T), old.faces)

    parts = tuple(replace(part, mesh=mesh(part.mesh)) for part in shape.parts)
    mobility = shape.mobility
    if mobility is not None:
        mobility = Mobility(tuple(replace(body, joint=joint(body.joint)) for body in mobility.bodies), mobility.junk)
    x, y, z = turn @ np.array(shape.up)
    return replace(shape, parts=parts, mobility=mobility, up=(float(x), float(y), float(z)))


def turned_shapes(shapes: Sequence[PreparedShape], folder: Path, *, freely: bool) -> list[PreparedShape]:
    """All shapes, each turned at random: about `up`, or freely with `up` turned along. Kept in `folder`."""
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for shape in shapes:
        path = folder / f"{shape.id}.safetensors"
        if not path.exists():
            rng = np.random.default_rng(seed_of(shape.id, 1))
            about_up = Rotation.from_rotvec(shape.up * rng.uniform(-np.pi, np.pi))
            turn = (Rotation.random(rng=rng) if freely else about_up).as_matrix()
            source = read_found(Found(Path(shape.source), Layout(shape.layout), shape.id))
            path.write_bytes(to_bytes(prepare_shape(turned(source, turn)), {}))
        found.append(read_prepared(path))
    return found
