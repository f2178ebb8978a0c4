"""From a shape's own frame and lengths to the normalised frame, in which models see it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility
from kinmo.core.prediction import JointEstimate
from kinmo.core.shape import Mesh, Shape, bounds_of
from kinmo.core.vector import Vector

_HASH_STEPS = 1e5
_HASH_RANGE = 1 << 18


@dataclass(frozen=True, eq=False)
class Normalisation:
    """normalised = (file - `center`) / `diagonal`: the file's axes, no turn."""

    center: Vector
    diagonal: float

    @classmethod
    def of(cls, shape: Shape) -> Normalisation:
        """Centre and diagonal of the shape's axis-aligned box."""
        return cls(shape.center, shape.diagonal)

    @classmethod
    def about(cls, meshes: Iterable[Mesh]) -> Normalisation:
        """Centre and diagonal of the axis-aligned box of some meshes."""
        low, high = bounds_of(meshes)
        return cls(0.5 * (low + high), float(np.linalg.norm(high - low)))

    def points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points [..., 3] of the file's frame in the normalised one."""
        return (points - self.center) / self.diagonal

    def mesh(self, mesh: Mesh) -> Mesh:
        return Mesh(self.points(mesh.vertices), mesh.faces)

    def joint(self, joint: Joint) -> Joint:
        return _rescaled(joint, self.points(joint.pivot), 1.0 / self.diagonal)

    def mobility(self, mobility: Mobility) -> Mobility:
        """The same bodies and joints in the normalised frame."""
        return mobility.with_joints(self.joint)

    def undo(self, mobility: Mobility) -> Mobility:
        """Bodies and joints of the normalised frame in the file's."""
        return mobility.with_joints(self.undo_joint)

    def undo_joint(self, joint: Joint) -> Joint:
        """A joint of the normalised frame in the file's."""
        return _rescaled(joint, joint.pivot * self.diagonal + self.center, self.diagonal)

    def estimate(self, estimate: JointEstimate) -> JointEstimate:
        """An estimate of the file's frame in the normalised one."""
        return estimate if estimate.joint is None else replace(estimate, joint=self.joint(estimate.joint))

    def undo_estimate(self, estimate: JointEstimate) -> JointEstimate:
        """An estimate of the normalised frame in the file's."""
        return estimate if estimate.joint is None else replace(estimate, joint=self.undo_joint(estimate.joint))


def _rescaled(joint: Joint, pivot: Vector, scale: float) -> Joint:
    if joint.kind is JointKind.REVOLUTE:
        return replace(joint, pivot=pivot)
    lower = None if joint.lower is None else joint.lower * scale
    upper = None if joint.upper is None else joint.upper * scale
    return replace(joint, pivot=pivot, lower=lower, upper=upper, rest=joint.rest * scale)


def geometry_hash(meshes: Iterable[Mesh]) -> str:
    """A hash of a shape's surface, given as meshes in the normalised frame.

    It is that of the set of vertices to 1e-5 diagonals: copies of a shape that differ in place, size, segmentation, or the
    order of parts, vertices and faces have the same, but for what rounding takes to the next step.
    """
    vertices = np.concatenate([mesh.corners for mesh in meshes])
    steps = np.round(vertices * _HASH_STEPS).astype(np.int64) + _HASH_RANGE // 2
    x, y, z = steps.T  # within half a diagonal of the origin, so that one number holds all three
    numbers = np.unique((x * _HASH_RANGE + y) * _HASH_RANGE + z)
    return blake2b(numbers.astype("<i8").tobytes(), digest_size=16).hexdigest()
