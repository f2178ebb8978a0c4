"""How scans come to networks, whatever their place, size and turn."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinmo import _core

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

Normalised = Literal["object", "scan"]
"""Whose size and place a scan is brought to: the object's true diagonal, its place kept; or the visible points' own."""
Axes = Literal["camera", "manhattan", "base"]
"""Along which axes networks see a scan: the camera's; those that its surfaces face (`manhattan_axes`); or those that the
surfaces of the base face, at a second look, when it has been said what that is (`base_axes`)."""

LEAST_BASE_POINTS = 50
"""With fewer of the base what it faces says less than what the whole scan does."""

LOWEST, HIGHEST = np.radians([-5.0, 90.0])
"""How far down cameras look: from a little below the object to straight from above."""


@dataclass(frozen=True, eq=False)
class InputFrame:
    """How points come to a network: `rotation`.T @ (camera - `center`) * `scale`."""

    center: F64
    scale: float
    rotation: F64 = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(
        cls, points: NDArray[np.floating], normalised: Normalised, diagonal: float = 1.0, rotation: F64 | None = None
    ) -> InputFrame:
        """For the points [n, 3] of a scan of an object with this `diagonal`, which only `object` looks at.

        Columns of `rotation` [3, 3] are the axes that they are to be seen along, the camera's unless given.
        """
        rotation = np.eye(3) if rotation is None else rotation
        if normalised == "object":
            return cls(np.zeros(3), 1.0 / diagonal, rotation)
        turned = rotation.T @ points.T  # NumPy is faster along rows
        low, high = turned.min(axis=1), turned.max(axis=1)
        center = 0.5 * rotation @ (low + high).astype(np.float64)
        return cls(center, 1.0 / max(float(np.linalg.norm(high - low)), 1e-9), rotation)

    def apply(self, points: NDArray[np.floating]) -> F32:
        """Points [..., 3] in the camera's frame, as networks see them."""
        return np.asarray((points - self.center) @ self.rotation * self.scale, np.float32)

    def undo(self, points: F64) -> F64:
        """Points [..., 3] that networks see, in the camera's frame."""
        return np.asarray(points / self.scale @ self.rotation.T + self.center)

    def undo_rotations(self, rotations: F64) -> F64:
        """Rotations [..., 3, 3] to what networks see, to the camera's frame."""
        return np.asarray(self.rotation @ rotations)


def scan_rotations(points: NDArray[np.floating], axes: Axes) -> F64:
    """Columns [F, 3, 3] are the axes that networks see scans [F, n, 3] along at first sight, in the camera's frame."""
    if axes == "camera":
        return np.tile(np.eye(3), (len(points), 1, 1))
    return manhattan_axes(points)


def base_axes(points: NDArray[np.floating], is_base: NDArray[np.bool_], first: F64) -> F64:
    """The axes [F, 3, 3] that the base in scans [F, n, 3] faces, its points marked by `is_base` [F, n]; those of `first`
    [F, 3, 3] where these are few.

    Of the whole scan, an open door may decide.
    """
    are_enough = is_base.sum(axis=1) >= LEAST_BASE_POINTS
    axes: F64 = first.copy()
    axes[are_enough] = manhattan_axes(points[are_enough], is_base[are_enough])
    return axes


def looks(points: NDArray[np.floating], parts: NDArray[np.integer]) -> F64:
    """The axes [F, 2, 3, 3] that networks see scans [F, n, 3] along at first sight, and then if they take `parts` [F, n] for
    those that points are of, the base being 0.
    """
    first = manhattan_axes(points)
    return np.stack([first, base_axes(points, parts == 0, first)], axis=1)


def manhattan_axes(points: NDArray[np.floating], which: NDArray[np.bool_] | None = None) -> F64:
    """The axes [F, 3, 3] that most surfaces of scans [F, n, 3] face, in the order of a camera's as far as can be told.

    Of the points those alone count that `which` [F, n] marks, if it is given, which must be some of every scan.

    Of the six directions up is the one that is nearest to where a camera that is held upright has up; ahead is, of the level
    ones, the one that points away from the camera most.
    """
    which = np.ones(points.shape[:2], bool) if which is None else which
    counted = which[..., None]
    low = points.min(axis=1, keepdims=True, where=counted, initial=np.inf)
    size = np.maximum(np.max(points - low, axis=(1, 2), keepdims=True, where=counted, initial=0.0), 1e-9)
    frames = np.swapaxes(_core.manhattan_frames(np.asarray((points - low) / size, np.float32), which), 1, 2)
    directions, rows = np.concatenate([frames, -frames], axis=1), np.arange(len(frames))
    up = directions[rows, _uprightness(directions).argmax(axis=1)]
    is_level = np.abs(np.einsum("fki,fi->fk", directions, up)) < 0.5
    away = np.einsum("fki,fi->fk", directions, points.mean(axis=1, where=counted))
    ahead = directions[rows, np.where(is_level, away, -np.inf).argmax(axis=1)]
    return np.stack([np.cross(-up, ahead), -up, ahead], axis=-1)


def _uprightness(directions: F64) -> F64:
    """The cosines [...] of the angles between directions [..., 3] and the nearest ones that are up for an upright camera.

    Those are up or towards the camera in its picture, and nothing to the side: an arc, for a camera that looks down by an angle
    in `LOWEST` to `HIGHEST`. (The nearest to the middle of that arc would not do: to a level camera the front of an object,
    turned towards it by up to half a right angle, is nearer.)
    """
    _, down, forward = np.moveaxis(directions, -1, 0)
    looks_down = np.clip(np.arctan2(-forward, -down), LOWEST, HIGHEST)
    return np.asarray(-down * np.cos(looks_down) - forward * np.sin(looks_down))
