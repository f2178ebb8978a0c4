"""Variants of a labelled object for training: mirrored, and stretched to other proportions."""

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
from kinmo.scans.canonical.closed_pose import Parts, rests_midway, with_positive_direction

F64 = NDArray[np.float64]

MIRROR = np.diag([1.0, -1.0, 1.0])
"""Reflection of left and right, in a frame with z up and the front at -x."""


def sample_variant_matrix(up: Vector, stretch: float, rng: np.random.Generator) -> F64:
    """Draw a matrix [3, 3] that mirrors an object with the unit vector `up` [3] with probability 1/2 and stretches it.

    The factors of the three directions (sideways, to the front, up) are 1 / `stretch` to `stretch`.
    """
    to_z_up = z_up_rotation(up)
    lengths = np.exp(rng.uniform(-1.0, 1.0, 3) * np.log(stretch))
    sides = MIRROR if rng.random() < 0.5 else np.eye(3)
    return np.asarray(to_z_up.T @ sides @ np.diag(lengths) @ to_z_up)


def apply_variant(mobility: Mobility, meshes: Sequence[Mesh], matrix: F64) -> Parts:
    """Map a closed object's points and axes by a matrix [3, 3] of `sample_variant_matrix`; joint angles stay.

    Faces still point outwards. A stretched open object would not close any more.
    """
    is_mirrored = bool(np.linalg.det(matrix) < 0.0)
    faces = (mesh.faces[:, ::-1] if is_mirrored else mesh.faces for mesh in meshes)
    moved = (Mesh(mesh.vertices @ matrix.T, np.ascontiguousarray(own)) for mesh, own in zip(meshes, faces, strict=True))
    return mobility.with_joints(lambda joint: _mapped(joint, matrix, is_mirrored)), tuple(moved)


def _mapped(joint: Joint, matrix: F64, is_mirrored: bool) -> Joint:
    along = matrix @ joint.direction
    length = float(np.linalg.norm(along))
    # A reflection reverses the sense of rotation.
    sense = -1.0 if is_mirrored and joint.kind is JointKind.REVOLUTE else 1.0
    moved = replace(joint, direction=sense * along / length, pivot=matrix @ joint.pivot)
    if joint.kind is not JointKind.REVOLUTE:
        lower, upper = (None if limit is None else limit * length for limit in (joint.lower, joint.upper))
        moved = replace(moved, lower=lower, upper=upper, rest=joint.rest * length)
    return with_positive_direction(moved) if rests_midway(moved) or not joint.is_limited else moved
