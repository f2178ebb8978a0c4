"""What ANCSH's public evaluation code prints for an estimate, its faults included, so that printed figures can be compared.

Its faults, of which the default measures (`scan_metrics`) have none:

- An angle that rounding makes no number counts as zero.
- Translations are those of the corner of NPCS, which turns carry along.
- The overlap of boxes is counted on a grid, by a test with edges in the wrong order: one of the three is a face's diagonal.
- A hinge's state is off by the angle between the two turns against the base, axes that are off included. A slider is taken to
  move along x of the base: from where the part's box begins by the network to where its visible points do.
- The distance of parallel axes counts as zero, and so do angle and distance of a joint that no point tells of.
- Frames are left out without a word, measure by measure, where what it is of was not found of any part.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.evaluation.metrics import axis_error
from kinmo.evaluation.scan_metrics import FrameScore, nothing_found
from kinmo.scans.articulated_object import Structure
from kinmo.scans.pose_fitting import ScanEstimate

F64 = NDArray[np.float64]

GRID = 50
"""Points along each side of the grid that boxes are compared on."""
CORNER, ENDS = (1, -1, 1), ((1, -1, -1), (-1, -1, -1), (1, 1, 1))
"""Signs of the corner from which a point is looked at, and of the three that are taken for its neighbours."""


def score_as_ancsh(
    found: ScanEstimate, true: ScanEstimate, structure: Structure, points: NDArray[np.floating], parts: NDArray[np.integer]
) -> FrameScore:
    """Errors of `found` in the scan `points` [n, 3] that are said to be of `parts` [n]; NaN in measures without the frame."""
    if not np.isfinite(found.poses.scales[0]):  # nothing can be told against the base
        return nothing_found(structure)
    has_poses, has_boxes, has_states = (
        bool(np.isfinite(values).all()) for values in (found.poses.scales, found.half_extents, found.states)
    )
    has_parents = bool(np.isfinite(found.poses.scales[list(structure.parents)]).all())
    clouds = [points[parts == row + 1] for row in range(len(structure.kinds))]
    are_seen = all(len(cloud) or kind is JointKind.REVOLUTE for cloud, kind in zip(clouds, structure.kinds, strict=True))
    with np.errstate(invalid="ignore", divide="ignore"):
        turned = [_angle(mine @ right.T) for mine, right in zip(found.poses.rotations, true.poses.rotations, strict=True)]
        corners = np.linalg.norm(found.poses.translations - true.poses.translations, axis=1)
        lines = [_line(found, true, row) for row in range(len(structure.kinds))]
        state = [
            _turn_error(found, true, row + 1) if kind is JointKind.REVOLUTE else _slide_error(found, true, row, clouds[row])
            for row, kind in enumerate(structure.kinds)
        ]
    axis = [axis_error(found.directions[row], true.directions[row]) for row in range(len(structure.kinds))]
    overlap = [box_overlap(_corners(found, part), _corners(true, part)) for part in range(structure.part_count)]
    return FrameScore(
        _only_if(has_poses, np.nan_to_num(np.array(turned))),
        _only_if(has_poses, corners),
        _only_if(has_poses and has_boxes, np.array(overlap)),
        _only_if(has_poses and has_boxes and has_states and are_seen, np.nan_to_num(np.array(state))),
        np.full(len(structure.kinds), np.nan),
        _only_if(has_parents, np.nan_to_num(np.array(axis))),
        _only_if(has_parents, np.nan_to_num(np.array(lines))),
    )


def _only_if(is_known: bool, values: F64) -> F64:
    return values if is_known else np.full_like(values, np.nan)


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


def _turn_error(found: ScanEstimate, true: ScanEstimate, part: int) -> float:
    mine, right = (said.poses.rotations[0].T @ said.poses.rotations[part] for said in (found, true))
    return _angle(mine @ right.T)


def _slide_error(found: ScanEstimate, true: ScanEstimate, row: int, cloud: NDArray[np.floating]) -> float:
    """For the visible points `cloud` [n, 3] of the part that joint `row` moves against the base."""
    if not len(cloud):
        return np.nan
    base, part = found.poses.rotations[0], row + 1
    begins = ((cloud - found.poses.translations[0]) @ base)[:, 0].min()
    middle = (found.centers[part] - found.poses.translations[part]) @ found.poses.rotations[part]
    begins_by_network = (middle[0] - found.half_extents[part, 0]) / found.poses.scales[part]
    slid = base[:, 0] * (begins - begins_by_network)
    return float(np.linalg.norm(true.states[row] * true.directions[row] - slid))
