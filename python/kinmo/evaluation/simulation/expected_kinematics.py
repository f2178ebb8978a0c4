"""The motion of links by kinmo's own forward kinematics, for comparison with simulators."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import z_up_rotation
from kinmo.core.joint import JointKind
from kinmo.core.kinematics import Pose, forward
from kinmo.core.links import links_of
from kinmo.core.mobility import Mobility
from kinmo.core.vector import Vector
from kinmo.evaluation.simulation.object_check import Kinematics


def expected_kinematics(mobility: Mobility, up: Vector, metres_per_unit: float) -> Kinematics:
    """The kinematics of the robot of a mobility.

    Args:
        mobility: Bodies and joints in the frame of the shape.
        up: Unit vector [3] that points up in that frame.
        metres_per_unit: Length of its unit in metres.

    Returns:
        A function from values of the robot's joints, by name, to the motion [4, 4] of each link from the pose of the file, in
        the frame of the robot.
    """
    links = links_of(mobility)
    frame = np.eye(4)
    frame[:3, :3] = metres_per_unit * z_up_rotation(np.asarray(up, float))
    back = np.linalg.inv(frame)

    def motions(values: Mapping[str, float]) -> dict[str, Pose]:
        main: dict[int, float] = {}
        angles: dict[int, float] = {}
        for link in links:
            if link.joint is None or link.body is None:
                continue
            rest, value = link.joint.rest, values.get(link.joint_name, 0.0)
            if link.joint.kind is JointKind.SCREW:
                main[link.body] = rest + values.get(link.slide_joint_name, 0.0) / metres_per_unit
                angles[link.body] = value
            else:
                main[link.body] = rest + (value if link.joint.has_pivot else value / metres_per_unit)
        poses: NDArray[np.float64] = frame @ forward(mobility, main, angles) @ back
        found = {link.name: np.eye(4) if link.body is None else poses[link.body] for link in links}
        for link in links:
            if link.body in angles:  # the light link of a screw slides, but does not turn
                still = {body: angle for body, angle in angles.items() if body != link.body}
                found[link.slide_link] = frame @ forward(mobility, main, still)[link.body] @ back
        return found

    return motions
