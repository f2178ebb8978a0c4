"""Exported objects in USD, which has no physics of its own: the stage is validated, and its joints are moved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdPhysics, UsdUtils
from scipy.spatial.transform import Rotation

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector
from kinmo.evaluation.simulation.object_check import MAX_POSE_ERROR, Kinematics, SimulationCheck, kinematics_problems
from kinmo.evaluation.simulation.simulator import LoadError, SimulatedJoint, Simulator

AXES = {"X": 0, "Y": 1, "Z": 2}


def check_stage(name: str, path: Path, kinematics: Kinematics, diagonal: float) -> SimulationCheck:
    """Test a USD file without a simulator. It does not tell if the object rests and moves.

    Args:
        name: Name of the simulator in the result.
        path: The file.
        kinematics: The motion of the links that is expected.
        diagonal: Diagonal of the object's bounding box in metres.
    """
    try:
        stage = UsdArticulation(path, max(diagonal, 1.0))
    except LoadError as error:
        return SimulationCheck(name, problems=(f"does not load: {error}",))
    scaled = _scaled(kinematics, stage.unit)
    differing = stage.misplaced_links() or kinematics_problems(cast(Simulator, stage), scaled)
    return SimulationCheck(name, loads=True, agrees=not differing, problems=tuple(differing))


def _scaled(kinematics: Kinematics, unit: float) -> Kinematics:
    def motions(values: Mapping[str, float]) -> dict[str, Pose]:
        return {link: _in_units(pose, unit) for link, pose in kinematics(values).items()}

    return motions


def _in_units(pose: Pose, unit: float) -> Pose:
    changed = np.array(pose)
    changed[:3, 3] /= unit
    return changed


class UsdArticulation:
    """The articulation of a USD file.

    USD holds the frames of joints in single precision. Lengths in `link_poses` are therefore in a unit of the object's size.

    Args:
        path: The file.
        unit: Unit of lengths in poses, in metres.

    Raises:
        LoadError: USD warns of the file, a validator finds an error, or it is no articulation with a fixed base.
    """

    def __init__(self, path: Path, unit: float = 1.0) -> None:
        self.unit = unit
        with _no_diagnostics():
            self._stage = Usd.Stage.Open(str(path))
            errors = _validation_errors(self._stage)
            if errors:
                raise LoadError(errors[0])
            prims = list(self._stage.Traverse())
            if sum(prim.HasAPI(UsdPhysics.ArticulationRootAPI) for prim in prims) != 1:
                raise LoadError("it has not one root of an articulation")
            self._poses = {
                prim.GetPath(): _pose(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
                for prim in prims
                if prim.HasAPI(UsdPhysics.RigidBodyAPI)
            }
            self._joints = [self._joint(UsdPhysics.Joint(prim)) for prim in prims if prim.IsA(UsdPhysics.Joint)]
        children = {joint.child for joint in self._joints}
        loose = [path.name for path in self._poses if path not in children]
        if loose:
            raise LoadError(f"no joint holds {loose[0]}")
        self.joints = tuple(joint.simulated for joint in self._joints if joint.simulated is not None)

    def _joint(self, joint: Any) -> _StageJoint:
        name = joint.GetPrim().GetName()
        parents, children = joint.GetBody0Rel().GetTargets(), joint.GetBody1Rel().GetTargets()
        for target in (*parents, *children):
            if not self._stage.GetPrimAtPath(target):
                raise LoadError(f"{name}: {target} is missing")
        if len(children) != 1 or children[0] not in self._poses:
            raise LoadError(f"{name} holds no body")
        frames = (
            _frame(joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            _frame(joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        )
        parent = parents[0] if parents and parents[0] in self._poses else None
        kinds = {UsdPhysics.RevoluteJoint: True, UsdPhysics.PrismaticJoint: False}
        for schema, is_angle in kinds.items():
            if joint.GetPrim().IsA(schema):
                moving = schema(joint.GetPrim())
                low, high = (float(each.Get()) for each in (moving.GetLowerLimitAttr(), moving.GetUpperLimitAttr()))
                unit = math.radians(1.0) if is_angle else 1.0
                limits = (unit * low, unit * high) if math.isfinite(low) and math.isfinite(high) else None
                simulated = SimulatedJoint(name, is_angle, limits)
                return _StageJoint(parent, children[0], frames, AXES[moving.GetAxisAttr().Get()], simulated)
        if not joint.GetPrim().IsA(UsdPhysics.FixedJoint):
            raise LoadError(f"{name} is neither hinge, slider nor fixed")
        return _StageJoint(parent, children[0], frames, 0, None)

    def misplaced_links(self) -> list[str]:
        """One line for the first link that is not drawn where its joint holds it at the value 0. Empty if there is none."""
        held = self.link_poses(np.zeros(len(self.joints)))
        for path, pose in self._poses.items():
            error = float(np.abs(_in_units(pose, self.unit) - held[path.name]).max())
            if error > MAX_POSE_ERROR:
                return [f"does not agree: {path.name} is drawn {error:.1e} away from its joint"]
        return []

    def link_poses(self, values: Vector) -> Mapping[str, Pose]:
        """Poses [4, 4] of all links by name at joint values [J] in radians and metres, with lengths in `unit`."""
        value_of = {joint.name: float(value) for joint, value in zip(self.joints, values, strict=True)}
        joint_of = {joint.child: joint for joint in self._joints}
        found: dict[Sdf.Path, Pose] = {}

        def pose(link: Sdf.Path) -> Pose:
            if link not in found:
                joint = joint_of[link]
                above = np.eye(4) if joint.parent is None else pose(joint.parent)
                value = 0.0 if joint.simulated is None else value_of[joint.simulated.name]
                found[link] = above @ joint.motion(value)
            return found[link]

        return {link.name: _in_units(pose(link), self.unit) for link in self._poses}


class _StageJoint:
    """A joint: its bodies (parent None for the world), its frame in each, its axis, and its degree of freedom if it has one."""

    def __init__(
        self,
        parent: Sdf.Path | None,
        child: Sdf.Path,
        frames: tuple[Pose, Pose],
        axis: int,
        simulated: SimulatedJoint | None,
    ) -> None:
        self.parent, self.child, self.simulated = parent, child, simulated
        self._frames, self._axis = frames, axis

    def motion(self, value: float) -> Pose:
        """Pose [4, 4] of the child in its parent at a value of the joint."""
        moved = np.eye(4)
        if self.simulated is not None and self.simulated.is_angle:
            moved[:3, :3] = Rotation.from_euler("xyz"[self._axis], value).as_matrix()
        else:
            moved[self._axis, 3] = value
        return np.asarray(self._frames[0] @ moved @ np.linalg.inv(self._frames[1]))


def _frame(place: Any, turn: Any) -> Pose:
    pose = np.eye(4)
    rotation = turn.Get()
    pose[:3, :3] = Rotation.from_quat([*rotation.GetImaginary(), rotation.GetReal()]).as_matrix()
    pose[:3, 3] = np.array(place.Get(), np.float64)
    return pose


def _pose(matrix: Gf.Matrix4d) -> NDArray[np.float64]:
    """A matrix of USD, which multiplies rows, as one that multiplies columns."""
    return np.asarray(np.array(matrix, np.float64).T)


def _validation_errors(stage: Usd.Stage) -> list[str]:
    """One line for each error that the validators of USD find, such as those of physics."""
    from pxr import UsdValidation

    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    return [" ".join(error.GetMessage().split()) for error in context.Validate(stage)]


@contextmanager
def _no_diagnostics() -> Iterator[None]:
    """Raise LoadError for the first warning or error of USD in the block."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    except Tf.ErrorException as error:
        first = error.args[0] if error.args else error
        raise LoadError(" ".join(str(getattr(first, "commentary", first)).split())) from None
    found = delegate.TakeUncoalescedDiagnostics()
    if found:
        raise LoadError(" ".join(found[0].commentary.split()))
