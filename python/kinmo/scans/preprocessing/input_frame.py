"""Input frames: normalisation of scans for the networks, whatever their position, scale and rotation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo import _core

F64 = NDArray[np.float64]

MIN_BASE_POINTS = 50
"""Number of base points from which on the base tells the axes better than the whole scan."""
MIN_PITCH, MAX_PITCH = np.radians([-5.0, 90.0])
"""Range of the angle by which cameras look down, rad: from slightly below the object to straight from above."""


@dataclass(frozen=True, eq=False)
class InputFrame:
    """Frame of a network's input: input = `rotation`.T @ (camera - `center`) * `scale`."""

    center: F64
    scale: float
    rotation: F64 = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(
        cls,
        points: NDArray[np.floating],
        normalised: Literal["object", "scan"],
        diagonal: float = 1.0,
        rotation: F64 | None = None,
    ) -> InputFrame:
        """Input frame of a scan with points [n, 3] in the camera frame.

        `object` divides by the object's true `diagonal` and keeps its position. `scan` uses the box of the points. The columns
        of `rotation` [3, 3] are the axes of the input in the camera frame; by default they are the camera's.
        """
        rotation = np.eye(3) if rotation is None else rotation
        if normalised == "object":
            return cls(np.zeros(3), 1.0 / diagonal, rotation)
        turned = rotation.T @ points.T  # NumPy is faster along rows
        low, high = turned.min(axis=1), turned.max(axis=1)
        center = 0.5 * rotation @ (low + high).astype(np.float64)
        return cls(center, 1.0 / max(float(np.linalg.norm(high - low)), 1e-9), rotation)

    def apply(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Map points [..., 3] from the camera frame to the input frame."""
        return np.asarray((points - self.center) @ self.rotation * self.scale, np.float32)

    def undo(self, points: F64) -> F64:
        """Map points [..., 3] from the input frame to the camera frame."""
        return np.asarray(points / self.scale @ self.rotation.T + self.center)

    def undo_rotations(self, rotations: F64) -> F64:
        """Map rotations [..., 3, 3] into the input frame to rotations into the camera frame."""
        return np.asarray(self.rotation @ rotations)


def base_axes(points: NDArray[np.floating], is_base: NDArray[np.bool_], first: F64) -> F64:
    """Input axes [F, 3, 3] of the second pass: those that the base faces. In the whole scan, an open door may decide.

    `is_base` [F, n] marks the base points. Scans with fewer than `MIN_BASE_POINTS` keep their axes of the first pass.
    Otherwise as in `manhattan_axes`.
    """
    are_enough = is_base.sum(axis=1) >= MIN_BASE_POINTS
    axes: F64 = first.copy()
    axes[are_enough] = manhattan_axes(points[are_enough], is_base[are_enough])
    return axes


def two_pass_axes(points: NDArray[np.floating], parts: NDArray[np.integer]) -> F64:
    """Input axes [F, 2, 3, 3] of the first and the second pass for scans with known parts [F, n]; the base is part 0."""
    first = manhattan_axes(points)
    return np.stack([first, base_axes(points, parts == 0, first)], axis=1)


def manhattan_axes(points: NDArray[np.floating], mask: NDArray[np.bool_] | None = None) -> F64:
    """Axes that most surfaces of a scan face (its Manhattan frame), ordered like a camera's.

    Of the six directions, up is the one nearest to up for an upright camera. Forward is the level direction that points most
    away from the camera. In scans [F, n, 3] the points in `mask` [F, n] count, at least one each. The axes right, down and
    forward are columns [F, 3, 3] in the camera frame, as the points are.
    """
    mask = np.ones(points.shape[:2], bool) if mask is None else mask
    counted = mask[..., None]
    low = points.min(axis=1, keepdims=True, where=counted, initial=np.inf)
    size = np.maximum(np.max(points - low, axis=(1, 2), keepdims=True, where=counted, initial=0.0), 1e-9)
    frames = np.swapaxes(_core.manhattan_frames(np.asarray((points - low) / size, np.float32), mask), 1, 2)
    directions, rows = np.concatenate([frames, -frames], axis=1), np.arange(len(frames))
    up = directions[rows, _uprightness(directions).argmax(axis=1)]
    is_level = np.abs(np.einsum("fki,fi->fk", directions, up)) < 0.5
    away = np.einsum("fki,fi->fk", directions, points.mean(axis=1, where=counted))
    forward = directions[rows, np.where(is_level, away, -np.inf).argmax(axis=1)]
    return np.stack([np.cross(-up, forward), -up, forward], axis=-1)


def _uprightness(directions: F64) -> F64:
    """Cosines [...] of the angles between directions [..., 3] and the nearest up direction of an upright camera.

    These up directions form an arc without sideways component, for cameras that look down by `MIN_PITCH` to `MAX_PITCH`. The
    middle of the arc alone would not do: a level camera may see the front of an object turned towards it by up to 45 degrees.
    The front is then nearer to that middle than up is.
    """
    _, down, forward = np.moveaxis(directions, -1, 0)
    pitch = np.clip(np.arctan2(-forward, -down), MIN_PITCH, MAX_PITCH)
    return np.asarray(-down * np.cos(pitch) - forward * np.sin(pitch))
