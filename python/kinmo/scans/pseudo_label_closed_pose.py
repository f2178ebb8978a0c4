"""Where joints of pseudo labels are closed: their limits only tell how far nothing stops them, too far or not far enough.

What is closed lies straight and takes up no room: a door that a file shows open is closed where its sides face the axes of the
file, one that could be pushed in through its frame is closed as it stands, and a drawer that sticks out is closed further in.
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
from kinmo.scans.axis_alignment import straight_values
from kinmo.scans.closed_pose import ALIKE, moved_by, room_of
from kinmo.scans.folding_joints import Fold, fold_of, folded
from kinmo.scans.joint_states import ROUNDING

F64 = NDArray[np.float64]

FARTHEST = math.radians(135.0)
"""From the pose of the file, to either side, within which a hinge is thought to be closed."""
QUARTER = 0.5 * math.pi
PER_QUARTER, OUT_OF_REACH = 0.25, 0.4
"""What it costs to be closed a quarter of a turn from the pose of the file, or farther beyond the limits than half of that. To
take up twice the room, with what it hangs by, costs 1."""
PULLED_OUT = 0.35
"""Share of a slider's length by which it sticks out of what it hangs by, from which on it is thought to be pulled out. It is
closed where it does not stick out any more."""
OPENING = math.radians(30.0)
"""Which way a closed part opens is where it takes up more room after this."""
NEAR = math.radians(2.0)
"""A part that is as near to closed is closed."""


def likely_closed(
    mobility: Mobility, meshes: Sequence[Mesh], widest: float, folds: Mapping[int, Fold] | None = None
) -> Mobility:
    """The same, its joints with one end where they are thought to be closed, hinges with the other within `widest` radians.

    A hinge whose limit is `widest` away from the pose of the file, where guesses end, is as wide from where it is closed.
    `meshes` are those of the bodies. What cannot lie straight folds if it crosses what it hangs by, as one half of scissors
    does the other; if not, its hinge keeps its limits, as do sliders that are not pulled out. The bodies of `folds` fold so in
    any case.
    """
    folds = folds or {}
    bodies = list(mobility.bodies)
    for index, body in mobility.movable():
        joint, parent = body.joint, body.parent
        if joint is None or parent is None or joint.lower is None or not len(meshes[parent].vertices):
            continue
        if index in folds:
            joint = folded(joint, folds[index], widest)
        elif joint.kind is JointKind.REVOLUTE:
            joint = _likely_hinge(joint, meshes[index], meshes[parent], widest)
        elif joint.kind is JointKind.PRISMATIC:
            joint = _likely_slider(joint, meshes[index].corners, meshes[parent].corners)
        bodies[index] = replace(body, joint=joint)
    return replace(mobility, bodies=tuple(bodies))


def _likely_slider(joint: Joint, cloud: F64, base: F64) -> Joint:
    own, fixed = cloud @ joint.direction, base @ joint.direction
    sticks_out = {1.0: float(own.max() - fixed.max()), -1.0: float(fixed.min() - own.min())}
    way = max(sticks_out, key=lambda way: sticks_out[way])
    if sticks_out[way] <= PULLED_OUT * float(np.ptp(own)) or joint.lower is None or joint.upper is None:
        return joint
    closed = joint.rest - way * sticks_out[way]
    ends = sorted((closed, closed + way * max(joint.upper - joint.lower, sticks_out[way])))
    return replace(joint, lower=ends[0], upper=ends[1])


def _likely_hinge(joint: Joint, mesh: Mesh, parent: Mesh, widest: float) -> Joint:
    cloud, base = mesh.corners, parent.corners
    angles = straight_values(joint, mesh, joint.rest - FARTHEST, joint.rest + FARTHEST) - joint.rest
    if joint.lower is None or joint.upper is None:
        return joint
    if not len(angles):
        fold = fold_of(joint, mesh, parent)
        return folded(joint, fold, widest) if fold is not None and fold.crosses else joint
    rooms = np.array([_room(joint, cloud, base, angle) for angle in angles])
    beyond = np.maximum(angles - (joint.upper - joint.rest), (joint.lower - joint.rest) - angles)
    costs = rooms / rooms.min() + PER_QUARTER * np.abs(angles) / QUARTER + OUT_OF_REACH * (beyond > 0.5 * QUARTER)
    closed = float(angles[np.argmin(costs)])
    ways = {1.0: joint.upper - joint.rest - closed, -1.0: closed + joint.rest - joint.lower}
    opens = _opens(joint, cloud, base, closed, ways)
    end = joint.upper if opens > 0.0 else joint.lower
    is_known = abs(end - joint.rest) < widest - ROUNDING and ways[opens] > OPENING
    width = min(ways[opens], widest - 2.0 * ROUNDING) if is_known else widest  # as wide as that, its end is not known
    ends = sorted((joint.rest + closed, joint.rest + closed + opens * width))
    return replace(joint, lower=ends[0], upper=ends[1])


def _opens(joint: Joint, cloud: F64, base: F64, closed: float, ways: Mapping[float, float]) -> float:
    """The way from closed to open, 1 or -1: to where the file shows it, where it takes up more room, or is free for longer."""
    if abs(closed) > NEAR:
        return -math.copysign(1.0, closed)
    rooms = {way: _room(joint, cloud, base, closed + way * OPENING) for way in ways}
    alike = abs(rooms[1.0] - rooms[-1.0]) <= ALIKE * max(rooms.values())
    by = ways if alike else rooms
    return max(by, key=lambda way: by[way])


def _room(joint: Joint, cloud: F64, base: F64, angle: float) -> float:
    """The volume of the box of a part, turned by an angle from the pose of the file, and what it hangs by."""
    turned = moved_by(joint_motion(joint, joint.rest + angle), cloud)
    return room_of(np.concatenate([turned, base]))
