"""Exported objects in MuJoCo."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco
import numpy as np

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector
from kinmo.evaluation.simulation.simulator import LoadError, RestRecord, SimulatedJoint

LOG_FILE = "MUJOCO_LOG.TXT"
"""File in the working folder that MuJoCo writes warnings to."""
STIFFNESS = (2.0 * np.pi * 4.0) ** 2
"""Acceleration per unit of error of a driven or held joint, 1/s2."""
DAMPING = 2.0 * STIFFNESS**0.5
"""Acceleration per unit of speed of a driven or held joint, 1/s: critical damping."""
SETTLE = 0.25
"""Share of the time of a drive at its end in which the target stays."""


class MujocoSimulator:
    """An object in MuJoCo (see `Simulator`)."""

    def __init__(self, path: Path) -> None:
        with _warnings() as log:
            try:
                self._model = mujoco.MjModel.from_xml_path(str(path))
            except ValueError as error:
                raise LoadError(" ".join(str(error).split())) from None
        if log:
            raise LoadError(" ".join(log[0].split()))
        self._data = mujoco.MjData(self._model)
        model = self._model
        kinds = {mujoco.mjtJoint.mjJNT_HINGE: True, mujoco.mjtJoint.mjJNT_SLIDE: False}
        if any(int(kind) not in map(int, kinds) for kind in model.jnt_type):
            raise LoadError("the base is not fixed")
        self.joints = tuple(
            SimulatedJoint(
                mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, index),
                int(model.jnt_type[index]) == int(mujoco.mjtJoint.mjJNT_HINGE),
                (float(model.jnt_range[index, 0]), float(model.jnt_range[index, 1])) if model.jnt_limited[index] else None,
            )
            for index in range(model.njnt)
        )

    def link_poses(self, values: Vector) -> Mapping[str, Pose]:
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = values
        mujoco.mj_kinematics(self._model, self._data)
        poses = {}
        for index in range(1, self._model.nbody):
            pose = np.eye(4)
            pose[:3, :3] = self._data.xmat[index].reshape(3, 3)
            pose[:3, 3] = self._data.xpos[index]
            poses[mujoco.mj_id2name(self._model, mujoco.mjtObj.mjOBJ_BODY, index)] = pose
        return poses

    def rest(self, seconds: float) -> RestRecord:
        model, data = self._model, self._data
        mujoco.mj_resetData(model, data)
        mujoco.mj_forward(model, data)
        gravity = -np.array(data.qfrc_bias)
        fastest, before, is_finite = 0.0, np.array(data.xpos), True
        for _ in range(round(seconds / model.opt.timestep)):
            mujoco.mj_step(model, data)
            is_finite = bool(np.isfinite(data.qpos).all()) and not data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number
            if not is_finite:
                break
            moved = np.linalg.norm(data.xpos - before, axis=1)
            fastest, before = max(fastest, float(moved.max()) / model.opt.timestep), np.array(data.xpos)
        penetration = max((-float(contact.dist) for contact in data.contact[: data.ncon]), default=0.0)
        return RestRecord(np.array(data.qpos), gravity, fastest, max(penetration, 0.0), is_finite)

    def drive(self, joint: int, targets: tuple[float, float], seconds: float) -> tuple[float, float]:
        model, data = self._model, self._data
        mujoco.mj_resetData(model, data)
        aims = np.zeros(model.nv)
        force = np.zeros(model.nv)
        low = high = start = 0.0
        steps = round(seconds / model.opt.timestep)
        for target in targets:
            for step in range(steps):
                aims[joint] = start + (target - start) * min(1.0, step / (steps * (1.0 - SETTLE)))
                mujoco.mj_step1(model, data)
                wanted = STIFFNESS * (aims - data.qpos) - DAMPING * data.qvel
                mujoco.mj_mulM(model, data, force, wanted)
                data.qfrc_applied[:] = force + data.qfrc_bias - data.qfrc_passive
                data.qfrc_applied[joint] += np.sign(target - start) * model.dof_frictionloss[joint]
                mujoco.mj_step2(model, data)
                low, high = min(low, float(data.qpos[joint])), max(high, float(data.qpos[joint]))
            start = target
        return low, high


@contextlib.contextmanager
def _warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's warnings. It writes them into its log in the working folder."""
    found: list[str] = []
    place = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield found
        finally:
            log = Path(folder) / LOG_FILE
            if log.exists():
                found += log.read_text(errors="replace").splitlines()
            os.chdir(place)
