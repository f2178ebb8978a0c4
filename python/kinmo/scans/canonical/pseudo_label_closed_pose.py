"""Closed poses of joints with guessed limits, as pseudo labels have them: a limit there only tells how far a part moves freely.

Closed parts are axis-aligned and take up little room. A door that the file shows open is closed where its sides face the axes
of the file. A door that could be pushed in through its frame is closed as it stands. A protruding drawer is closed further in.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import Joint, JointKind
from kinmo.core.kinematics import joint_motion
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Mesh
from kinmo.scans.canonical.closed_pose import are_equal_volumes, axis_aligned_values, box_volume, transform_points
from kinmo.scans.canonical.folding_joints import FoldingJoint, find_folding_joint, with_folding_limits
from kinmo.scans.canonical.hinge_openings import ROUNDING

F64 = NDArray[np.float64]

SEARCH_RANGE = math.radians(135.0)
"""Largest angle between the file's pose and the closed pose of a hinge, rad."""
QUARTER = 0.5 * math.pi
QUARTER_TURN_COST, BEYOND_LIMITS_COST = 0.25, 0.4
"""Costs of a closed pose a quarter turn away from the file's pose, and of one more than half a quarter turn beyond the limits.
The unit is the box volume of the part and its parent over the least such volume."""
MIN_PROTRUSION = 0.35
"""Share of a slider's length by which an opened slider protrudes from its parent at least. It is closed where the protrusion
ends."""
TEST_OPENING = math.radians(30.0)
"""Opening at which the box volume tells the opening direction, rad."""
CLOSED_TOLERANCE = math.radians(2.0)
"""Largest angle between the file's pose and the closed pose of a closed part, rad."""


def estimate_closed_limits(
    mobility: Mobility, meshes: Sequence[Mesh], max_guessed_opening: float, foldings: Mapping[int, FoldingJoint] | None = None
) -> Mobility:
    """Replace guessed limits by limits that start at the estimated closed pose.

    A guessed limit that is `max_guessed_opening` away from the file's pose is no known end: such a hinge gets this width. A
    hinge whose part has no axis-aligned pose folds if the part crosses its parent, as one half of scissors does. Otherwise it
    keeps its limits. Sliders that do not protrude keep theirs too. The `foldings` by body index close where their tips meet.
    Meshes are those of the bodies, as in the file.
    """
    foldings = foldings or {}
    bodies = list(mobility.bodies)
    for index, body in mobility.movable():
        joint, parent = body.joint, body.parent
        if joint is None or parent is None or joint.lower is None or not len(meshes[parent].vertices):
            continue
        if index in foldings:
            joint = with_folding_limits(joint, foldings[index], max_guessed_opening)
        elif joint.kind is JointKind.REVOLUTE:
            joint = _close_hinge(joint, meshes[index], meshes[parent], max_guessed_opening)
        elif joint.kind is JointKind.PRISMATIC:
            joint = _close_slider(joint, meshes[index].corners, meshes[parent].corners)
        bodies[index] = replace(body, joint=joint)
    return replace(mobility, bodies=tuple(bodies))


def _close_slider(joint: Joint, cloud: F64, parent: F64) -> Joint:
    own, fixed = cloud @ joint.direction, parent @ joint.direction
    protrusions = {1.0: float(own.max() - fixed.max()), -1.0: float(fixed.min() - own.min())}
    sign = max(protrusions, key=lambda sign: protrusions[sign])
    if protrusions[sign] <= MIN_PROTRUSION * float(np.ptp(own)) or joint.lower is None or joint.upper is None:
        return joint
    closed = joint.rest - sign * protrusions[sign]
    lower, upper = sorted((closed, closed + sign * max(joint.upper - joint.lower, protrusions[sign])))
    return replace(joint, lower=lower, upper=upper)


def _close_hinge(joint: Joint, mesh: Mesh, parent: Mesh, max_guessed_opening: float) -> Joint:
    cloud, fixed = mesh.corners, parent.corners
    angles = axis_aligned_values(joint, mesh, joint.rest - SEARCH_RANGE, joint.rest + SEARCH_RANGE) - joint.rest
    if joint.lower is None or joint.upper is None:
        return joint
    if not len(angles):
        folding = find_folding_joint(joint, mesh, parent)
        return with_folding_limits(joint, folding, max_guessed_opening) if folding is not None and folding.crosses else joint
    volumes = np.array([_volume(joint, cloud, fixed, angle) for angle in angles])
    beyond = np.maximum(angles - (joint.upper - joint.rest), (joint.lower - joint.rest) - angles)
    turn_costs, limit_costs = QUARTER_TURN_COST * np.abs(angles) / QUARTER, BEYOND_LIMITS_COST * (beyond > 0.5 * QUARTER)
    closed = float(angles[np.argmin(volumes / volumes.min() + turn_costs + limit_costs)])
    widths = {1.0: joint.upper - joint.rest - closed, -1.0: closed + joint.rest - joint.lower}
    sign = _opening_sign(joint, cloud, fixed, closed, widths)
    end = joint.upper if sign > 0.0 else joint.lower
    is_known = abs(end - joint.rest) < max_guessed_opening - ROUNDING and widths[sign] > TEST_OPENING
    # A known end stays narrower than `max_guessed_opening`, which marks unknown ends.
    width = min(widths[sign], max_guessed_opening - 2.0 * ROUNDING) if is_known else max_guessed_opening
    lower, upper = sorted((joint.rest + closed, joint.rest + closed + sign * width))
    return replace(joint, lower=lower, upper=upper)


def _opening_sign(joint: Joint, cloud: F64, fixed: F64, closed: float, widths: Mapping[float, float]) -> float:
    """Direction from closed to open, 1 or -1: towards the file's pose, the larger box volume, or the wider free range."""
    if abs(closed) > CLOSED_TOLERANCE:
        return -math.copysign(1.0, closed)
    volumes = {sign: _volume(joint, cloud, fixed, closed + sign * TEST_OPENING) for sign in widths}
    scores = widths if are_equal_volumes(volumes[1.0], volumes[-1.0]) else volumes
    return max(scores, key=lambda sign: scores[sign])


def _volume(joint: Joint, cloud: F64, fixed: F64, angle: float) -> float:
    """Box volume of a part, turned by an angle from the file's pose, together with its parent."""
    turned = transform_points(joint_motion(joint, joint.rest + angle), cloud)
    return box_volume(np.concatenate([turned, fixed]))
