"""The motions that a part's axes allow, and numbers that describe each against the rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo import _core
from kinmo.evidence.scene import Scene, Unit
from kinmo.hypotheses import CENTRAL, Lines, distinct_directions

F64 = NDArray[np.float64]

REVOLUTE, PRISMATIC, SCREW = 0, 1, 2
SWEPT_ANGLE = np.pi / 2
SWEPT_LENGTH = 0.3
PROBES = 96
STEPS = 8


def hypotheses_of(lines: Lines) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Kind [h] and line [h] of every hypothesis: turn about each line, slide along each direction, screw about central ones."""
    slides = distinct_directions(lines)
    screws = np.flatnonzero(lines.sources[:, list(CENTRAL)].any(axis=1))
    kinds = np.repeat([REVOLUTE, PRISMATIC, SCREW], [len(lines), len(slides), len(screws)])
    return kinds, np.concatenate([np.arange(len(lines)), slides, screws])


def motion_features(scene: Scene, unit: Unit, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Kind, sliding along the contact, and free travel of each motion [h, B]."""
    w = unit.contact_weights
    turning = np.cross(directions[:, None], unit.contact[None] - pivots[:, None])
    turning /= np.maximum(np.linalg.norm(turning, axis=-1).max(axis=1), 1e-6)[:, None, None]
    velocity = np.where((kinds == PRISMATIC)[:, None, None], directions[:, None], turning)
    across = np.einsum("hni,ni->hn", velocity, unit.toward)
    speed = np.linalg.norm(velocity, axis=-1) @ w
    normal = np.abs(across) @ w
    one_sided = np.abs(across @ w) / np.maximum(normal, 1e-6)
    features = {
        "kind": np.eye(3)[kinds],
        "into the contact": normal,
        "against sliding": normal / np.maximum(speed, 1e-6),
        "one-sided": one_sided,
        "blocked one way": one_sided * normal,
        "travel": free_travel(scene, unit, kinds, directions, pivots),
    }
    return np.column_stack(list(features.values()))


def free_travel(scene: Scene, unit: Unit, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Free travel either way over what was tried, and the shares that collide, the lesser first [h, 4]. A screw is turned."""
    if not unit.rest:
        return np.tile([1.0, 1.0, 0.0, 0.0], (len(kinds), 1))
    limit = np.where(kinds == PRISMATIC, SWEPT_LENGTH, SWEPT_ANGLE)
    swept = (kinds == PRISMATIC).astype(np.uint8)
    lower, upper, penetration = _core.sweep(
        scene.meshes, list(unit.leaves), unit.rest, swept, directions, pivots, -limit, limit, probes=PROBES, steps=STEPS
    )
    travel = np.abs(np.stack([lower, upper], axis=1)) / limit[:, None]
    return np.column_stack([np.sort(travel, axis=1), np.sort(penetration, axis=1)])
