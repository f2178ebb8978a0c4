"""The motions that a part's axes allow, and numbers that describe each against the rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.features.candidate_lines import CENTRAL, Lines, distinct_directions
from kinmo.features.scene import Unit

F64 = NDArray[np.float64]

REVOLUTE, PRISMATIC, SCREW = 0, 1, 2


def hypotheses_of(lines: Lines) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Kind [h] and line [h] of every hypothesis: turn about each line, slide along each direction, screw about central ones."""
    slides = distinct_directions(lines)
    screws = np.flatnonzero(lines.sources[:, list(CENTRAL)].any(axis=1))
    kinds = np.repeat([REVOLUTE, PRISMATIC, SCREW], [len(lines), len(slides), len(screws)])
    return kinds, np.concatenate([np.arange(len(lines)), slides, screws])


def motion_features(unit: Unit, kinds: NDArray[np.int64], directions: F64, pivots: F64) -> F64:
    """Kind, and how each motion slides along the contact or runs into it [h, B].

    Swept collisions (`kinmo.features.free_travel`) are no evidence here: they cost more than all the rest and decided nothing.
    """
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
    }
    return np.column_stack(list(features.values()))
