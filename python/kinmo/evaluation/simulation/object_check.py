"""Tests of one exported object in one simulator (docs/background/metrics.md, "Simulators")."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector
from kinmo.evaluation.simulation.simulator import RestRecord, SimulatedJoint, Simulator

REST_SECONDS = 1.0
MAX_DRIFT = 0.02
"""Largest movement of a resting joint, as a share of its range."""
MAX_SPEED = 1.0
"""Largest speed of a link of a resting object, m/s."""
MAX_PENETRATION = 0.001
"""Deepest penetration of a resting object, in diagonals."""
MIN_REACH = 0.95
"""Least share of its range that a driven joint reaches."""
DRIVE_SECONDS = 2.0
"""Time from one end of the range to the other."""
STATES = 100
"""Random joint states that the kinematics is compared in."""
MAX_POSE_ERROR = 1e-6
"""Largest difference of two poses, in metres and in entries of a rotation matrix."""
ENDLESS = (-math.pi, math.pi)
"""Range that stands for that of a joint without limits, in radians."""
MIN_GRAVITY = 1e-4
"""Least generalised force of gravity that opens a joint, in N or N m."""

Kinematics = Callable[[Mapping[str, float]], Mapping[str, Pose]]
"""Motion [4, 4] of every link from the pose of the file, in the world, for joint values by name."""


@dataclass(frozen=True)
class SimulationCheck:
    """Result of the tests of one object in one simulator.

    Attributes:
        simulator: Name of the simulator.
        loads: It loads without an error or a warning.
        rests: It stays at rest for `REST_SECONDS`, but for joints that gravity opens.
        moves: Every joint reaches `MIN_REACH` of its range.
        agrees: Its links are where kinmo's kinematics puts them.
        problems: One line for each test that failed.
    """

    simulator: str
    loads: bool = False
    rests: bool = False
    moves: bool = False
    agrees: bool = False
    problems: tuple[str, ...] = field(default=())

    @property
    def works(self) -> bool:
        """True if all tests are passed."""
        return self.loads and self.rests and self.moves and self.agrees


def check_object(name: str, simulator: Simulator, kinematics: Kinematics, diagonal: float) -> SimulationCheck:
    """Test an object that is loaded.

    Args:
        name: Name of the simulator.
        simulator: The simulator with the object.
        kinematics: The motion of the links that is expected.
        diagonal: Diagonal of the object's bounding box in metres.
    """
    resting = rest_problems(simulator.joints, simulator.rest(REST_SECONDS), diagonal)
    moving = [problem for index in range(len(simulator.joints)) if (problem := drive_problem(simulator, index))]
    differing = kinematics_problems(simulator, kinematics)
    return SimulationCheck(name, True, not resting, not moving, not differing, (*resting, *moving, *differing))


def rest_problems(joints: Sequence[SimulatedJoint], record: RestRecord, diagonal: float) -> list[str]:
    """Reasons why an object does not stay at rest. `diagonal` is that of the object, in metres."""
    if not record.is_finite:
        return ["does not rest: the simulation diverges"]
    found = []
    for joint, value, gravity in zip(joints, record.values, record.gravity, strict=True):
        low, high = joint.limits or ENDLESS
        falls = abs(gravity) > MIN_GRAVITY and value * gravity > 0.0
        if abs(value) > MAX_DRIFT * max(high - low, 1e-9) and not falls:
            unit = f"{math.degrees(value):.1f} degrees" if joint.is_angle else f"{1000.0 * value:.1f} mm"
            found.append(f"does not rest: {joint.name} moves by {unit}")
    if record.fastest > MAX_SPEED:
        found.append(f"does not rest: a link reaches {record.fastest:.1f} m/s")
    if record.penetration > MAX_PENETRATION * diagonal:
        found.append(f"does not rest: two links overlap by {1000.0 * record.penetration:.1f} mm")
    return found


def drive_problem(simulator: Simulator, index: int) -> str:
    """Reason why a joint does not move through its range. Empty if it does."""
    joint = simulator.joints[index]
    low, high = joint.limits or ENDLESS
    least, most = simulator.drive(index, (low, high), DRIVE_SECONDS)
    reached = (min(most, high) - max(least, low)) / max(high - low, 1e-9)
    return "" if reached >= MIN_REACH else f"does not move: {joint.name} reaches {100.0 * max(reached, 0.0):.0f} % of its range"


def kinematics_problems(simulator: Simulator, kinematics: Kinematics, seed: int = 0) -> list[str]:
    """A link that joints.json does not have, or else the one that differs most from kinmo's kinematics in random states.

    Empty if no link differs.
    """
    rng = np.random.default_rng(seed)
    still = simulator.link_poses(np.zeros(len(simulator.joints)))
    worst, name = 0.0, ""
    for _ in range(STATES):
        values: Vector = np.array([rng.uniform(*(joint.limits or ENDLESS)) for joint in simulator.joints])
        expected = kinematics({joint.name: float(value) for joint, value in zip(simulator.joints, values, strict=True)})
        for link, pose in simulator.link_poses(values).items():
            if link not in expected:
                return [f"does not agree: joints.json has no link {link}: run kinmo export again"]
            error = float(np.abs(pose - expected[link] @ still[link]).max())
            if error > worst:
                worst, name = error, link
    if worst <= MAX_POSE_ERROR:
        return []
    return [f"does not agree: {name} is off by {worst:.1e} from joints.json: run kinmo export again"]
