"""Exported objects in PyBullet."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pybullet
from scipy.spatial.transform import Rotation

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector
from kinmo.evaluation.simulation.simulator import LoadError, RestRecord, SimulatedJoint

GRAVITY = (0.0, 0.0, -9.81)
TIME_STEP = 1.0 / 240.0
CONTACT_RANGE = 0.001
"""Distance in metres up to which contacts are kept. PyBullet's own 20 mm lets links that turn jam at contacts that are gone."""
SETTLE = 0.25
"""Share of the time of a drive at its end in which the target stays."""


class PybulletSimulator:
    """An object in PyBullet, where all links collide with each other (see `Simulator`).

    PyBullet reads the friction of joints but does not apply it. A motor that brakes with this force stands for it.
    """

    def __init__(self, path: Path) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=TIME_STEP, contactBreakingThreshold=CONTACT_RANGE, physicsClientId=self._client
        )
        flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_SELF_COLLISION_INCLUDE_PARENT
        flags |= pybullet.URDF_USE_INERTIA_FROM_FILE
        try:
            self._body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=self._client)
        except pybullet.error as error:
            self.close()
            raise LoadError(str(error)) from None
        infos = [pybullet.getJointInfo(self._body, index, self._client) for index in range(self._count)]
        self._moving = [info[0] for info in infos if info[2] in (pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC)]
        self._names = {info[0]: info[12].decode() for info in infos}
        self._friction = {info[0]: float(info[7]) for info in infos}
        self.joints = tuple(
            SimulatedJoint(
                info[1].decode(), info[2] == pybullet.JOINT_REVOLUTE, (info[8], info[9]) if info[8] < info[9] else None
            )
            for info in infos
            if info[0] in self._moving
        )

    @property
    def _count(self) -> int:
        return int(pybullet.getNumJoints(self._body, self._client))

    def close(self) -> None:
        """End the connection to the simulator."""
        pybullet.disconnect(self._client)

    def _reset(self, values: Vector | None = None) -> None:
        for place, index in enumerate(self._moving):
            value = 0.0 if values is None else float(values[place])
            pybullet.resetJointState(self._body, index, value, 0.0, physicsClientId=self._client)
            pybullet.setJointMotorControl2(
                self._body, index, pybullet.VELOCITY_CONTROL, force=self._friction[index], physicsClientId=self._client
            )

    def _values(self) -> Vector:
        states = pybullet.getJointStates(self._body, self._moving, physicsClientId=self._client) if self._moving else ()
        return np.array([state[0] for state in states])

    def link_poses(self, values: Vector) -> Mapping[str, Pose]:
        self._reset(values)
        poses = {}
        for index in range(self._count):
            state = pybullet.getLinkState(self._body, index, computeForwardKinematics=True, physicsClientId=self._client)
            pose = np.eye(4)
            pose[:3, :3] = Rotation.from_quat(state[5]).as_matrix()
            pose[:3, 3] = state[4]
            poses[self._names[index]] = pose
        return poses

    def rest(self, seconds: float) -> RestRecord:
        self._reset()
        pybullet.setGravity(*GRAVITY, physicsClientId=self._client)
        zeros = [0.0] * len(self._moving)
        torques = pybullet.calculateInverseDynamics(self._body, zeros, zeros, zeros, physicsClientId=self._client) or zeros
        fastest, before = 0.0, self._origins()
        is_finite = True
        for _ in range(round(seconds / TIME_STEP)):
            pybullet.stepSimulation(physicsClientId=self._client)
            after = self._origins()
            is_finite = bool(np.isfinite(after).all())
            if not is_finite:
                break
            if len(after):
                fastest = max(fastest, float(np.linalg.norm(after - before, axis=1).max()) / TIME_STEP)
            before = after
        points = pybullet.getContactPoints(self._body, self._body, physicsClientId=self._client) or ()
        penetration = max((-point[8] for point in points), default=0.0)
        return RestRecord(self._values(), -np.array(torques), fastest, max(penetration, 0.0), is_finite)

    def _origins(self) -> Vector:
        states = [pybullet.getLinkState(self._body, index, physicsClientId=self._client)[4] for index in range(self._count)]
        return np.array(states).reshape(-1, 3)

    def drive(self, joint: int, targets: tuple[float, float], seconds: float) -> tuple[float, float]:
        self._reset()
        pybullet.setGravity(0.0, 0.0, 0.0, physicsClientId=self._client)
        low = high = start = 0.0
        steps = round(seconds / TIME_STEP)
        for target in targets:
            for step in range(steps):
                for place, index in enumerate(self._moving):
                    aim = 0.0
                    if place == joint:
                        aim = start + (target - start) * min(1.0, step / (steps * (1.0 - SETTLE)))
                    pybullet.setJointMotorControl2(
                        self._body, index, pybullet.POSITION_CONTROL, targetPosition=aim, physicsClientId=self._client
                    )
                pybullet.stepSimulation(physicsClientId=self._client)
                value = pybullet.getJointState(self._body, self._moving[joint], physicsClientId=self._client)[0]
                low, high = min(low, value), max(high, value)
            start = target
        return low, high
