"""The normalised frame that models see: a shape centred on its bounding box and divided by its diagonal."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from hashlib import blake2b

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh, Shape, bounds_of
from kinmo.core.shape_estimate import JointEstimate
from kinmo.core.vector import Vector

_HASH_STEPS = 1e5
"""Resolution of `geometry_hash`, in steps per diagonal."""
_HASH_RANGE = 1 << 18
"""Number of steps that `geometry_hash` can tell apart along each axis."""


@dataclass(frozen=True, eq=False)
class Normalisation:
    """The map from a shape's own frame to the normalised frame: normalised = (own - `center`) / `diagonal`, without rotation.

    Attributes:
        center: [3], centre of the axis-aligned bounding box.
        diagonal: diagonal of that box.
    """

    center: Vector
    diagonal: float

    @classmethod
    def of(cls, shape: Shape) -> Normalisation:
        """The normalisation of a shape, from its axis-aligned bounding box."""
        return cls(shape.center, shape.diagonal)

    @classmethod
    def about(cls, meshes: Iterable[Mesh]) -> Normalisation:
        """The normalisation by the axis-aligned bounding box of some meshes."""
        low, high = bounds_of(meshes)
        return cls(0.5 * (low + high), float(np.linalg.norm(high - low)))

    def points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Normalise points [..., 3]."""
        return (points - self.center) / self.diagonal

    def mesh(self, mesh: Mesh) -> Mesh:
        """Normalise a mesh."""
        return Mesh(self.points(mesh.vertices), mesh.faces)

    def joint(self, joint: Joint) -> Joint:
        """Normalise a joint: its pivot, and its range if that is in lengths."""
        return _rescaled(joint, self.points(joint.pivot), 1.0 / self.diagonal)

    def mobility(self, mobility: Mobility) -> Mobility:
        """Normalise all joints of a mobility."""
        return mobility.with_joints(self.joint)

    def estimate(self, estimate: JointEstimate) -> JointEstimate:
        """Normalise the joint of an estimate."""
        return estimate if estimate.joint is None else replace(estimate, joint=self.joint(estimate.joint))

    def undo_joint(self, joint: Joint) -> Joint:
        """A normalised joint in the shape's own frame."""
        return _rescaled(joint, joint.pivot * self.diagonal + self.center, self.diagonal)

    def undo_mobility(self, mobility: Mobility) -> Mobility:
        """A normalised mobility in the shape's own frame."""
        return mobility.with_joints(self.undo_joint)

    def undo_estimate(self, estimate: JointEstimate) -> JointEstimate:
        """A normalised estimate in the shape's own frame."""
        return estimate if estimate.joint is None else replace(estimate, joint=self.undo_joint(estimate.joint))


def _rescaled(joint: Joint, pivot: Vector, scale: float) -> Joint:
    if joint.kind is JointKind.REVOLUTE:
        return replace(joint, pivot=pivot)
    lower = None if joint.lower is None else joint.lower * scale
    upper = None if joint.upper is None else joint.upper * scale
    return replace(joint, pivot=pivot, lower=lower, upper=upper, rest=joint.rest * scale)


def geometry_hash(meshes: Iterable[Mesh]) -> str:
    """Hash of a shape's surface, to recognise copies of a shape: 32 hexadecimal digits.

    The hash covers the set of used vertices, rounded to 1e-5 diagonals. It does not depend on position, size, segmentation, or
    the order of parts, vertices and faces. Rounding errors at the border between two steps change it.

    Args:
        meshes: all parts of the shape, in the normalised frame.
    """
    vertices = np.concatenate([mesh.corners for mesh in meshes])
    steps = np.round(vertices * _HASH_STEPS).astype(np.int64) + _HASH_RANGE // 2
    x, y, z = steps.T  # coordinates are within half a diagonal of the origin: one integer holds all three
    numbers = np.unique((x * _HASH_RANGE + y) * _HASH_RANGE + z)
    return blake2b(numbers.astype("<i8").tobytes(), digest_size=16).hexdigest()
