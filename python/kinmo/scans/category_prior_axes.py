"""Directions of joints: along axes of NAOCS, where that is typical and nothing that is said clearly tells otherwise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.scans.articulated_object import Structure
from kinmo.scans.category_prior import Typical
from kinmo.scans.point_predictions import PointAnswers, telling

F64 = NDArray[np.float64]

NEAR_AXIS = np.cos(np.radians(20.0))
"""From this cosine on a direction that typically is along an axis may be taken for that axis."""

MOST_RISE = 1.5
"""Two parts on a joint along the axis may disagree with their points by so many times what they do with the said one."""

LEAST_CERTAIN = 2
"""Points that tell of a joint; of fewer nothing shows how far they are to be relied on."""

CERTAINTY = 100.0
"""Points that agree with each other so many times better than with the axis know what they say: those of networks are
off together by a few times as much as they are off from each other, or less."""


def likely_directions(
    answers: Sequence[PointAnswers],
    said: Sequence[F64],
    free: tuple[F64, F64, F64],
    structure: Structure,
    typical: Typical,
    threshold: float,
) -> list[F64]:
    """The directions [K - 1, 3] of each frame, from those that are `said`.

    A joint that typically is along an axis, and said to be within `NEAR_AXIS` of one, is along that, unless all points that
    tell of it say otherwise as one, or its two parts, tied by it, then lie clearly worse. `free` are the rotations, scales and
    translations of all parts of all frames, found without joints; pairs count up to `threshold`.
    """
    directions = [own.copy() for own in said]
    for frame, answer in enumerate(answers):
        for row in np.flatnonzero(typical.along_axes):
            axis = _nearest_axis(said[frame][row])
            if axis is None or _is_certain(answer.axes[telling(answer, row + 1)], said[frame][row], axis):
                continue
            parts = structure.parents[row], int(row) + 1
            rotations, scales, translations = (values[frame * structure.part_count + np.array(parts)] for values in free)
            both = np.stack([axis, said[frame][row]])
            poses = rotations, scales, translations
            along, as_said = _costs(answer, parts, poses, structure.kinds[row], both, threshold)
            if not along > MOST_RISE * as_said:
                directions[frame][row] = axis
    return directions


def _nearest_axis(direction: F64) -> F64 | None:
    """The axis that a unit vector is near to, with its sign; none if it is to none."""
    nearest = np.argmax(np.abs(direction))
    if not abs(direction[nearest]) >= NEAR_AXIS:
        return None
    axis = np.zeros(3)
    axis[nearest] = np.sign(direction[nearest])
    return axis


def _is_certain(axes: F64, said: F64, axis: F64) -> bool:
    """Whether points that say the axes [n, 3] can only mean what they say."""
    lengths = np.linalg.norm(axes, axis=1)
    if len(axes) < LEAST_CERTAIN or not lengths.all():
        return False
    spread = np.median(np.linalg.norm(axes / lengths[:, None] - said, axis=1))
    return bool(np.linalg.norm(axis - said) > CERTAINTY * spread)


def _costs(
    answer: PointAnswers,
    parts: tuple[int, int],
    poses: tuple[F64, F64, F64],
    kind: JointKind,
    directions: F64,
    threshold: float,
) -> F64:
    """What two parts that a joint with each of the `directions` [n, 3] ties disagree with their points [n].

    The points are those that agree with the `poses` of the parts on their own; NaN where a part has none.
    """
    rotations, scales, translations = poses
    if not np.isfinite(scales).all():
        return np.full(len(directions), np.nan)
    clouds = []
    for row, part in enumerate(parts):
        source, target = answer.on_part(part)
        right = _residuals(source, target, rotations[row], scales[row], translations[row]) < threshold
        clouds.append((source[right], target[right]))
    count = len(directions)
    source, target = (np.concatenate([cloud[side] for cloud in clouds] * count) for side in (0, 1))
    starts = np.cumsum([0, *[len(own) for own, _ in clouds] * count], dtype=np.int64)
    ties = np.arange(2 * count, dtype=np.uint32).reshape(count, 2), np.full(count, kind.code, np.uint8), directions
    begin = np.tile(rotations, (count, 1, 1)), np.tile(scales, count), np.tile(translations, (count, 1))
    tied = _core.tie_poses(
        source, target, starts, *ties, *begin, frames=2 * np.arange(count + 1, dtype=np.int64), threshold=threshold
    )
    residuals = [_residuals(*clouds[pose % 2], *(values[pose] for values in tied)) for pose in range(2 * count)]
    costs = [np.minimum(each, threshold).sum() for each in residuals]
    return np.asarray(np.reshape(costs, (count, 2)).sum(axis=1))


def _residuals(source: F64, target: F64, rotation: F64, scale: float, translation: F64) -> F64:
    return np.asarray(np.linalg.norm(scale * source @ rotation.T + translation - target, axis=1))
