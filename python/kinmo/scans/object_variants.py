"""Objects like one that is labelled: the same mechanism, mirrored and in other proportions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.scans.closed_pose import is_midway, pointed_as_usual

F64 = NDArray[np.float64]

SIDEWAYS = np.diag([1.0, -1.0, 1.0])
"""Left for right, in a frame with z up and the front at -x."""


def draw_change(up: Vector, stretch: float, rng: np.random.Generator) -> F64:
    """A matrix [3, 3]: one time in two left for right, and each of the object's three directions (sideways, to the front, `up`)
    up to `stretch` times as long or as short.
    """
    to_z_up = z_up_rotation(up)
    lengths = np.exp(rng.uniform(-1.0, 1.0, 3) * np.log(stretch))
    sides = SIDEWAYS if rng.random() < 0.5 else np.eye(3)
    return np.asarray(to_z_up.T @ sides @ np.diag(lengths) @ to_z_up)


def changed(mobility: Mobility, meshes: Sequence[Mesh], change: F64) -> tuple[Mobility, tuple[Mesh, ...]]:
    """The object with all its points and axes where the matrix `change` [3, 3] takes them; angles of joints stay.

    `meshes` are those of the bodies. To be asked of an object that is closed: what is stretched open does not close any more.
    """
    is_mirrored = bool(np.linalg.det(change) < 0.0)
    faces = (mesh.faces[:, ::-1] if is_mirrored else mesh.faces for mesh in meshes)
    moved = (Mesh(mesh.vertices @ change.T, np.ascontiguousarray(own)) for mesh, own in zip(meshes, faces, strict=True))
    return mobility.with_joints(lambda joint: _joint(joint, change, is_mirrored)), tuple(moved)


def _joint(joint: Joint, change: F64, is_mirrored: bool) -> Joint:
    along = change @ joint.direction
    length = float(np.linalg.norm(along))
    # what turns to the right about a line turns to the left about its mirror image
    sense = -1.0 if is_mirrored and joint.kind is JointKind.REVOLUTE else 1.0
    moved = replace(joint, direction=sense * along / length, pivot=change @ joint.pivot)
    if joint.kind is not JointKind.REVOLUTE:
        lower, upper = (None if limit is None else limit * length for limit in (joint.lower, joint.upper))
        moved = replace(moved, lower=lower, upper=upper, rest=joint.rest * length)
    return pointed_as_usual(moved) if is_midway(moved) or not joint.is_limited else moved
