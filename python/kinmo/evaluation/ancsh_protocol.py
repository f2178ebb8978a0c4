"""The figures that ANCSH's public evaluation code would print, with its faults, to compare with printed figures.

The default measures (`scan_metrics`) have none of these faults:

* A rotation angle that rounding makes NaN counts as zero.
* The translation is that of the corner of the NPCS frame, which rotation errors move along.
* The overlap of boxes is counted on a grid, by a test with edges in the wrong order: one of the three is a face's diagonal.
* The state error of a hinge is the angle between the two rotations relative to the base, axis errors included.
* A slider is taken to move along x of the base, from the start of the predicted box to the start of the visible points.
* Parallel axes have distance zero. A joint that no point predicts has angle and distance zero.
* A frame is dropped silently from a measure that it lacks something for.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.evaluation.metrics import axis_error
from kinmo.evaluation.scan_metrics import FrameScore, nothing_found
from kinmo.scans.object_structure import Structure
from kinmo.scans.poses.scan_estimate import ScanEstimate

F64 = NDArray[np.float64]

GRID = 50  # number of grid points along each side of the space in which boxes are compared
CORNER = (1, 0, 1)  # index in `_corners` of the corner that the point-in-box test starts from
NEIGHBOURS = ((1, 0, 0), (0, 0, 0), (1, 1, 1))
"""Indices of the three corners that it takes for the neighbours of `CORNER`."""


def score_as_ancsh(
    found: ScanEstimate, true: ScanEstimate, structure: Structure, points: NDArray[np.floating], parts: NDArray[np.integer]
) -> FrameScore:
    """Errors of an estimate as the public code computes them; NaN in measures that the frame is dropped from.

    Estimates and the points [n, 3] of the scan are in the camera's frame, in diagonals of the object. `parts` [n] are the
    predicted parts of the points.
    """
    if not np.isfinite(found.poses.scales[0]):  # nothing is known relative to the base
        return nothing_found(structure)
    has_poses, has_boxes, has_states = (
        bool(np.isfinite(values).all()) for values in (found.poses.scales, found.half_extents, found.states)
    )
    has_parents = bool(np.isfinite(found.poses.scales[list(structure.parents)]).all())
    clouds = [points[parts == row + 1] for row in range(len(structure.kinds))]
    are_seen = all(len(cloud) or kind is JointKind.REVOLUTE for cloud, kind in zip(clouds, structure.kinds, strict=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        rotation = [_angle(mine @ right.T) for mine, right in zip(found.poses.rotations, true.poses.rotations, strict=True)]
        corners = np.linalg.norm(found.poses.translations - true.poses.translations, axis=1)
        lines = [_line(found, true, row) for row in range(len(structure.kinds))]
        state = [
            _turn_error(found, true, row + 1) if kind is JointKind.REVOLUTE else _slide_error(found, true, row, clouds[row])
            for row, kind in enumerate(structure.kinds)
        ]
    axis = [axis_error(found.directions[row], true.directions[row]) for row in range(len(structure.kinds))]
    overlap = [box_overlap(_corners(found, part), _corners(true, part)) for part in range(structure.part_count)]
    return FrameScore(
        _only_if(has_poses, np.nan_to_num(np.array(rotation))),
        _only_if(has_poses, corners),
        _only_if(has_poses and has_boxes, np.array(overlap)),
        _only_if(has_poses and has_boxes and has_states and are_seen, np.nan_to_num(np.array(state))),
        np.full(len(structure.kinds), np.nan),
        _only_if(has_parents, np.nan_to_num(np.array(axis))),
        _only_if(has_parents, np.nan_to_num(np.array(lines))),
    )


def _only_if(is_known: bool, values: F64) -> F64:
    return values if is_known else np.full_like(values, np.nan)


def box_overlap(first: F64, second: F64) -> float:
    """Overlap of two boxes, given by their `_corners`, on the public code's grid; too large, see the module."""
    both = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])
    sides = [np.linspace(low, high, GRID) for low, high in zip(both.min(axis=0), both.max(axis=0), strict=True)]
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = [_counted_inside(places, corners) for corners in (first, second)]
    union = np.count_nonzero(inside[0] | inside[1])
    return float(np.count_nonzero(inside[0] & inside[1]) / union) if union else 1.0


def _counted_inside(places: F64, corners: F64) -> NDArray[np.bool_]:
    origin = corners[CORNER]
    inside = np.ones(len(places), bool)
    for neighbour in NEIGHBOURS:
        edge = corners[neighbour] - origin
        along = (places - origin) @ edge
        inside &= (along > 0.0) & (along < edge @ edge)
    return inside


def _corners(estimate: ScanEstimate, part: int) -> F64:
    """Corners [2, 2, 2, 3] of the box of a part, at the lower (0) or upper (1) end of its x, y and z."""
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 3, indexing="ij"), axis=-1)
    return np.asarray(estimate.centers[part] + (signs * estimate.half_extents[part]) @ estimate.poses.rotations[part].T)


def _angle(rotation: F64) -> float:
    """Rotation angle without clipping the cosine to [-1, 1]: NaN for some rotations of almost no angle."""
    return float(np.arccos((np.trace(rotation) - 1.0) / 2.0))


def _line(found: ScanEstimate, true: ScanEstimate, row: int) -> float:
    normal = np.cross(found.directions[row], true.directions[row])
    offset = found.pivots[row] - true.pivots[row]
    return float(abs(normal @ offset) / np.linalg.norm(normal))


def _turn_error(found: ScanEstimate, true: ScanEstimate, part: int) -> float:
    mine, right = (estimate.poses.rotations[0].T @ estimate.poses.rotations[part] for estimate in (found, true))
    return _angle(mine @ right.T)


def _slide_error(found: ScanEstimate, true: ScanEstimate, row: int, cloud: NDArray[np.floating]) -> float:
    """State error of the slider `row`; `cloud` [n, 3] are the visible points of its part."""
    if not len(cloud):
        return np.nan
    base, part = found.poses.rotations[0], row + 1
    start = ((cloud - found.poses.translations[0]) @ base)[:, 0].min()
    middle = (found.centers[part] - found.poses.translations[part]) @ found.poses.rotations[part]
    predicted_start = (middle[0] - found.half_extents[part, 0]) / found.poses.scales[part]
    slid = base[:, 0] * (start - predicted_start)
    return float(np.linalg.norm(true.states[row] * true.directions[row] - slid))
