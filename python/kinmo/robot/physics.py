"""Physical constants of robots. By default, damping keeps heavy parts from falling fast, and friction holds light ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from kinmo.core.errors import InputError
from kinmo.robot.inertia import DENSITY, joined
from kinmo.robot.robot import Robot, RobotJoint, RobotJointKind

GRAVITY = 9.81
"""Acceleration in m/s2, along -z."""
DECAY = 2.0
"""Rate at which free motion dies out at least, in 1/s."""
MAX_DECAY = 60.0
"""Largest such rate of light parts, in 1/s. Simulators with explicit time steps bear no larger ones."""
MAX_FALL = 0.5
"""Speed that a part reaches at most when it falls by its weight, in m/s."""
MAX_HELD = 2.0
"""Largest force of weight at the rim of a part that dry friction holds, in N: that of knobs and buttons, but not of lids."""
MIN_REACH = 1e-6
"""Distance of the rim from the axis in metres below which a part has no moment."""
TILT = 1e-3
"""Least deviation of the upright component of an axis from 1 at which turning about it tilts what it carries."""
HOLD = 1.5
"""Dry friction of joints that hold their part, in forces of its weight."""
MIN_FRICTION = 0.2
"""Least dry friction at the rim of a part, in N, and least damping at the speed `MAX_FALL`: knobs do not spin on."""


@dataclass(frozen=True)
class Physics:
    """Physical constants of a robot.

    Attributes:
        density: density of parts in kg/m3.
        part_densities: other densities in kg/m3, by name of the part.
        damping: damping of all joints in N s/m or N m s/rad. None for the least damping that keeps parts from falling fast.
        friction: dry friction of all joints in N or N m. None for a little, which also holds light parts, such as buttons,
            against their weight.
        effort: largest force of a motor in N or N m.
        velocity: largest speed in m/s or rad/s.

    Raises:
        InputError: a density is not above 0, or another constant is below 0 or not finite. It names the field.
    """

    density: float = DENSITY
    part_densities: Mapping[str, float] = field(default_factory=dict)
    damping: float | None = None
    friction: float | None = None
    effort: float = 100.0
    velocity: float = 10.0

    def __post_init__(self) -> None:
        densities = {"density": self.density} | {f"part_densities.{name}": each for name, each in self.part_densities.items()}
        for field_name, value in densities.items():
            if not 0.0 < value < math.inf:
                raise InputError("physics", f"expected a positive number, got {value}", field_name)
        constants = {"damping": self.damping, "friction": self.friction, "effort": self.effort, "velocity": self.velocity}
        for field_name, constant in constants.items():
            if constant is not None and not 0.0 <= constant < math.inf:
                raise InputError("physics", f"expected a finite number of at least 0, got {constant}", field_name)

    def density_of(self, part: str) -> float:
        """Density of a part by its name, in kg/m3."""
        return self.part_densities.get(part, self.density)


DEFAULT_PHYSICS = Physics()
"""The physics for users who state nothing."""


def with_resistance(robot: Robot, physics: Physics) -> Robot:
    """The robot with the damping and the friction of the physics, or the default ones where it states none.

    Default damping is the least at which no part falls faster than `MAX_FALL`, free motion dies out, and a light push moves no
    part faster either. Default friction is `MIN_FRICTION`, or more where that holds a part whose weight is at most `MAX_HELD`
    at its rim.
    """
    joints = []
    for joint in robot.joints:
        damping, friction = _default_resistance(robot, joint)
        joints.append(
            replace(
                joint,
                damping=damping if physics.damping is None else physics.damping,
                friction=friction if physics.friction is None else physics.friction,
            )
        )
    return replace(robot, joints=tuple(joints))


def _default_resistance(robot: Robot, joint: RobotJoint) -> tuple[float, float]:
    """Damping and friction of a joint by the links that it moves."""
    moving = [robot.links[index] for index in robot.links_below(joint.child)]
    origin = moving[0].origin
    body = joined(link.inertial for link in moving)
    weight = GRAVITY * body.mass
    upright, level = abs(float(joint.axis[2])), float(np.hypot(*joint.axis[:2]))
    if _is_tilted(robot, joint):
        upright = level = 1.0
    if joint.kind is RobotJointKind.PRISMATIC:
        force = weight * upright
        return _damping(body.mass, 1.0, force), _friction(force)
    arm = float(np.linalg.norm(np.cross(joint.axis, body.center - origin)))
    points = [visual.mesh.vertices for link in moving for visual in link.visuals]
    reach = max((float(np.linalg.norm(np.cross(joint.axis, each - origin), axis=1).max()) for each in points), default=0.0)
    moment = weight * arm * level  # the largest one while it turns
    inertia = float(joint.axis @ body.inertia @ joint.axis) + body.mass * arm**2
    force = moment / max(reach, MIN_REACH)
    return _damping(inertia, reach, force), reach * _friction(force)


def _damping(inertia: float, reach: float, force: float) -> float:
    """Damping by the inertia, the distance of the rim from the axis (1 for sliders), and the force of the weight there."""
    light = min(reach**2 * MIN_FRICTION / MAX_FALL, MAX_DECAY * inertia)
    return max(DECAY * inertia, reach**2 * force / MAX_FALL, light)


def _friction(force: float) -> float:
    """Dry friction at the rim of a part, in N, by the force of its weight there."""
    return max(MIN_FRICTION, HOLD * force if force <= MAX_HELD else 0.0)


def _is_tilted(robot: Robot, joint: RobotJoint) -> bool:
    """True if a joint above tilts the axis."""
    carrier = robot.joint_of(joint.parent)
    while carrier is not None:
        if carrier.kind is not RobotJointKind.PRISMATIC and abs(float(carrier.axis[2])) < 1.0 - TILT:
            return True
        carrier = robot.joint_of(carrier.parent)
    return False
