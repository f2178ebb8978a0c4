"""What ANCSH's public evaluation code prints for an estimate, its faults included, so that printed figures can be compared.

Its faults, of which the default measures (`scan_metrics`) have none:

- A rotation error that rounding makes no number counts as zero.
- Translations are those of the corner of NPCS, which turns carry along.
- The overlap of boxes is counted on a grid, by a test with edges in the wrong order: one of the three is a face's diagonal.
- Of a hinge's state only the size of the angle counts, whatever the axis; a slider is taken to move along x of the base.
- The distance of parallel axes counts as zero.
- Frames in which anything was not found are left out without a word.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kinmo.evaluation.metrics import axis_error
from kinmo.evaluation.scan_metrics import FrameScore
from kinmo.joint import JointKind
from kinmo.scans.articulated_object import Structure
from kinmo.scans.estimate import ScanEstimate

F64 = NDArray[np.float64]

GRID = 50
"""Points along each side of the grid that boxes are compared on."""
CORNER, ENDS = (1, -1, 1), ((1, -1, -1), (-1, -1, -1), (1, 1, 1))
"""Signs of the corner from which a point is looked at, and of the three that are taken for its neighbours."""


def score_as_ancsh(found: ScanEstimate, true: ScanEstimate, structure: Structure) -> FrameScore | None:
    """Errors of `found`; None for a frame that the public code drops."""
    known = (found.poses.scales, found.half_extents, found.directions, found.states)
    if not all(np.isfinite(values).all() for values in known):
        return None
    with np.errstate(invalid="ignore", divide="ignore"):
        turned = [_angle(mine @ right.T) for mine, right in zip(found.poses.rotations, true.poses.rotations, strict=True)]
        corners = np.linalg.norm(found.poses.translations - true.poses.translations, axis=1)
        lines = [_line(found, true, row) for row in range(len(structure.kinds))]
    state = [_state_error(found, true, row, kind) for row, kind in enumerate(structure.kinds)]
    axis = [axis_error(found.directions[row], true.directions[row]) for row in range(len(structure.kinds))]
    overlap = [box_overlap(_corners(found, part), _corners(true, part)) for part in range(structure.part_count)]
    return FrameScore(
        np.nan_to_num(np.array(turned)),
        np.nan_to_num(corners),
        np.nan_to_num(corners),
        np.array(overlap),
        np.array(state),
        np.array(axis),
        np.nan_to_num(np.array(lines)),
    )


def box_overlap(mine: F64, right: F64) -> float:
    """The overlap of two boxes, given as functions of signs would be: corners [2, 2, 2, 3] by sign along x, y and z."""
    both = np.concatenate([mine.reshape(-1, 3), right.reshape(-1, 3)])
    sides = [np.linspace(low, high, GRID) for low, high in zip(both.min(axis=0), both.max(axis=0), strict=True)]
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = [_said_inside(places, corners) for corners in (mine, right)]
    union = np.count_nonzero(inside[0] | inside[1])
    return float(np.count_nonzero(inside[0] & inside[1]) / union) if union else 1.0


def _said_inside(places: F64, corners: F64) -> NDArray[np.bool_]:
    origin = _at(corners, CORNER)
    inside = np.ones(len(places), bool)
    for end in ENDS:
        edge = _at(corners, end) - origin
        along = (places - origin) @ edge
        inside &= (along > 0.0) & (along < edge @ edge)
    return inside


def _at(corners: F64, signs: tuple[int, int, int]) -> F64:
    return np.asarray(corners[tuple((sign + 1) // 2 for sign in signs)])


def _corners(estimate: ScanEstimate, part: int) -> F64:
    """Corners [2, 2, 2, 3] of the box of a part."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1)
    return np.asarray(estimate.centers[part] + (signs * estimate.half_extents[part]) @ estimate.poses.rotations[part].T)


def _angle(rotation: F64) -> float:
    """Not held to what an arc cosine can be of."""
    return float(np.arccos((np.trace(rotation) - 1.0) / 2.0))


def _line(found: ScanEstimate, true: ScanEstimate, row: int) -> float:
    normal = np.cross(found.directions[row], true.directions[row])
    offset = found.pivots[row] - true.pivots[row]
    return float(abs(normal @ offset) / np.linalg.norm(normal))


def _state_error(found: ScanEstimate, true: ScanEstimate, row: int, kind: JointKind) -> float:
    part = row + 1
    if kind is JointKind.REVOLUTE:
        mine, right = (
            float(np.arccos(np.clip((np.trace(said.poses.rotations[0].T @ said.poses.rotations[part]) - 1.0) / 2.0, -1.0, 1.0)))
            for said in (found, true)
        )
        return abs(mine - right)
    # how far the part's own middle is from where the base has it, along x of the base
    shifts = []
    for said in (found, true):
        base = said.poses.rotations[0]
        shifts.append(float((base.T @ (said.centers[part] - said.centers[0]))[0]) / float(said.poses.scales[0]))
    return abs(shifts[0] - shifts[1]) if math.isfinite(shifts[0]) else math.nan
