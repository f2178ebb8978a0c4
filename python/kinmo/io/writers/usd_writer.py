"""USD: the object as an articulation of UsdPhysics in a binary file. z up, metres, kilograms, degrees.

The default prim holds the scope `Geometry` with a rigid body for each link, and the scope `Physics` with the joints. A link has
its parts in `visuals` and what it collides with in `collisions`, which is not drawn. Materials are in the scope `Looks`. Their
images are files beside the USD file, which other formats share.

The schemas of USD have no place for the largest speed and the dry friction of joints. They are written as attributes of PhysX
(Isaac Sim, Omniverse) and Newton, which other programs ignore.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.frames import quaternion
from kinmo.core.names import unique_names
from kinmo.core.oriented_box import Box
from kinmo.core.shape import Mesh
from kinmo.core.vector import Vector
from kinmo.io.readers.optional_library import optional_library
from kinmo.io.writers.robot_meshes import textures_of
from kinmo.io.writers.texture_images import TextureImages, materials_of
from kinmo.io.writers.usd_frames import axis_frame, principal_inertia
from kinmo.io.writers.usd_looks import UsdLooks
from kinmo.io.writers.writer import ExportedObject
from kinmo.robot.collision_shapes import Cylinder, Hull
from kinmo.robot.robot import Collision, RobotJoint, RobotJointKind, RobotLink, Visual

ENDING = ".usd"
FIXED_JOINT = "fixed_base"
"""Name of the joint that fixes the base, unless another joint has it."""


def write_usd(exported: ExportedObject, folder: Path) -> Path:
    """Write a USD file (see `kinmo.io.writers.writer.Writer`). Raises InputError if usd-core is not installed."""
    path = folder / f"{exported.options.name}{ENDING}"
    check_usd_library(path)
    textures = textures_of(exported.robot, folder, lambda line: exported.note(f"usd: {line}"))
    stage = usd_stage(exported, textures)
    with tempfile.TemporaryDirectory() as place:  # USD misreads paths with brackets and some other characters
        draft = Path(place) / f"model{ENDING}"
        stage.GetRootLayer().Export(str(draft))
        shutil.copyfile(draft, path)
    return path


def check_usd_library(where: Path | str) -> None:
    """Raise InputError about `where` if usd-core is not installed."""
    optional_library("pxr", "usd", where, "USD needs usd-core", "write it")


def usd_stage(exported: ExportedObject, textures: TextureImages) -> Any:
    """The stage (`pxr.Usd.Stage`) of an object. The images of its materials are written as files."""
    return _StageWriter(exported, textures).stage


class _StageWriter:
    """Writes the robot of an object into a new stage."""

    def __init__(self, exported: ExportedObject, textures: TextureImages) -> None:
        from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics, Vt

        self.gf, self.sdf, self.usd, self.geom, self.physics, self.vt = Gf, Sdf, Usd, UsdGeom, UsdPhysics, Vt
        robot = exported.robot
        self.robot, self.shape = robot, exported.shape
        self.stage = Usd.Stage.Open(Sdf.Layer.CreateAnonymous(ENDING))
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        UsdPhysics.SetStageKilogramsPerUnit(self.stage, 1.0)
        self.root = UsdGeom.Xform.Define(self.stage, f"/{robot.name}").GetPrim()
        self.stage.SetDefaultPrim(self.root)
        model = Usd.ModelAPI(self.root)
        model.SetKind(Kind.Tokens.component)
        model.SetAssetName(robot.name)
        UsdPhysics.ArticulationRootAPI.Apply(self.root)
        materials = materials_of(visual.mesh for link in robot.links for visual in link.visuals)
        place = self.root.GetPath().AppendChild("Looks")
        self.looks = UsdLooks(self.stage, place, materials, textures, lambda line: exported.note(f"usd: {line}"))
        links = self._scope(self.root, "Geometry")
        self.links = [self._link(links, link) for link in robot.links]
        joints = self._scope(self.root, "Physics")
        self._fixed_base(joints)
        for joint in robot.joints:
            self._joint(joints, joint)

    def _scope(self, above: Any, name: str) -> Any:
        return self.geom.Scope.Define(self.stage, above.GetPath().AppendChild(name)).GetPrim()

    def _link(self, above: Any, link: RobotLink) -> Any:
        form = self.geom.Xform.Define(self.stage, above.GetPath().AppendChild(link.name))
        form.AddTranslateOp().Set(self.gf.Vec3d(*link.origin.tolist()))
        prim = form.GetPrim()
        self.usd.ModelAPI(prim).SetKind("subcomponent")
        self.physics.RigidBodyAPI.Apply(prim)
        moments, axes = principal_inertia(link.inertial.inertia)
        mass = self.physics.MassAPI.Apply(prim)
        mass.CreateMassAttr(link.inertial.mass)
        mass.CreateCenterOfMassAttr(self._vector(link.inertial.center - link.origin))
        mass.CreateDiagonalInertiaAttr(self._vector(moments))
        mass.CreatePrincipalAxesAttr(self.gf.Quatf(*axes.tolist()))
        if link.visuals:
            place = self._scope(prim, "visuals")
            for visual in link.visuals:
                self._visual(place, visual, link.origin)
        if link.collisions:
            place = self._scope(prim, "collisions")
            self.geom.Imageable(place).CreatePurposeAttr(self.geom.Tokens.guide)
            for collision in link.collisions:
                self._collision(place, collision, link.origin)
        return prim

    def _visual(self, above: Any, visual: Visual, origin: Vector) -> None:
        mesh = self._mesh(above, visual.name, visual.mesh, origin)
        self.looks.add(mesh, visual.mesh)
        name = self.shape.parts[visual.leaf].name
        if name and name != visual.name:
            mesh.GetPrim().SetDisplayName(name)

    def _collision(self, above: Any, collision: Collision, origin: Vector) -> None:
        shape = collision.shape
        if isinstance(shape, Box):
            prim = self._box(above, collision.name, shape, origin)
        elif isinstance(shape, Cylinder):
            prim = self._cylinder(above, collision.name, shape, origin)
        else:
            written = self._mesh(above, collision.name, shape.mesh, origin)
            self.looks.add_normals(written, shape.mesh)
            prim = written.GetPrim()
            approximation = self.physics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr()
            approximation.Set(self.physics.Tokens.convexHull if isinstance(shape, Hull) else self.physics.Tokens.none)
        self.physics.CollisionAPI.Apply(prim)

    def _box(self, above: Any, name: str, box: Box, origin: Vector) -> Any:
        cube = self.geom.Cube.Define(self.stage, above.GetPath().AppendChild(name))
        cube.CreateSizeAttr(2.0)
        cube.CreateExtentAttr([self.gf.Vec3f(-1.0), self.gf.Vec3f(1.0)])
        self._place(cube, box.center - origin, box.axes)
        cube.AddScaleOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Vec3d(*box.half_extents.tolist()))
        return cube.GetPrim()

    def _cylinder(self, above: Any, name: str, cylinder: Cylinder, origin: Vector) -> Any:
        written = self.geom.Cylinder.Define(self.stage, above.GetPath().AppendChild(name))
        written.CreateAxisAttr(self.geom.Tokens.z)
        written.CreateRadiusAttr(cylinder.radius)
        written.CreateHeightAttr(2.0 * cylinder.half_length)
        high = [cylinder.radius, cylinder.radius, cylinder.half_length]
        written.CreateExtentAttr([self.gf.Vec3f(*(-each for each in high)), self.gf.Vec3f(*high)])
        self._place(written, cylinder.center - origin, cylinder.frame)
        return written.GetPrim()

    def _place(self, written: Any, center: Vector, axes: NDArray[np.float64]) -> None:
        """Move a shape to a centre, and turn it so that its axes are the rows [3, 3]."""
        written.AddTranslateOp().Set(self.gf.Vec3d(*center.tolist()))
        turn = quaternion(axes.T)
        written.AddOrientOp(self.geom.XformOp.PrecisionDouble).Set(self.gf.Quatd(*turn.tolist()))

    def _mesh(self, above: Any, name: str, mesh: Mesh, origin: Vector) -> Any:
        written = self.geom.Mesh.Define(self.stage, above.GetPath().AppendChild(name))
        points = self.vt.Vec3fArray.FromNumpy((mesh.vertices - origin).astype(np.float32))
        written.CreatePointsAttr(points)
        written.CreateFaceVertexCountsAttr(self.vt.IntArray.FromNumpy(np.full(len(mesh.faces), 3, np.int32)))
        written.CreateFaceVertexIndicesAttr(self.vt.IntArray.FromNumpy(mesh.faces.astype(np.int32).ravel()))
        written.CreateSubdivisionSchemeAttr(self.geom.Tokens.none)
        written.CreateDoubleSidedAttr(True)
        written.CreateExtentAttr(self.geom.PointBased.ComputeExtent(points))
        return written

    def _fixed_base(self, above: Any) -> None:
        name = unique_names([*(joint.name for joint in self.robot.joints), FIXED_JOINT])[-1]
        joint = self.physics.FixedJoint.Define(self.stage, above.GetPath().AppendChild(name))
        # The default prim is no body and stands for the world: the object may be placed anywhere in a larger scene.
        joint.CreateBody0Rel().SetTargets([self.root.GetPath()])
        joint.CreateBody1Rel().SetTargets([self.links[0].GetPath()])
        self._frames(joint, self.robot.links[0].origin, np.array([1.0, 0.0, 0.0, 0.0]))

    def _joint(self, above: Any, joint: RobotJoint) -> None:
        slides = joint.kind is RobotJointKind.PRISMATIC
        schema = self.physics.PrismaticJoint if slides else self.physics.RevoluteJoint
        written = schema.Define(self.stage, above.GetPath().AppendChild(joint.name))
        written.CreateBody0Rel().SetTargets([self.links[joint.parent].GetPath()])
        written.CreateBody1Rel().SetTargets([self.links[joint.child].GetPath()])
        axis, turn = axis_frame(joint.axis)
        written.CreateAxisAttr(axis)
        self._frames(written, self.robot.links[joint.child].origin - self.robot.links[joint.parent].origin, turn)
        unit = 1.0 if slides else float(np.degrees(1.0))
        if joint.lower is not None and joint.upper is not None:
            written.CreateLowerLimitAttr(unit * joint.lower)
            written.CreateUpperLimitAttr(unit * joint.upper)
        # A drive without stiffness and with the target speed 0 is a damper.
        way = "linear" if slides else "angular"
        drive = self.physics.DriveAPI.Apply(written.GetPrim(), way)
        drive.CreateTypeAttr(self.physics.Tokens.force)
        drive.CreateStiffnessAttr(0.0)
        drive.CreateDampingAttr(joint.damping / unit)
        drive.CreateMaxForceAttr(joint.effort)
        prim, velocity, friction = written.GetPrim(), unit * joint.velocity, joint.friction
        self._apply(prim, "PhysxJointAPI", {"physxJoint:maxJointVelocity": velocity})
        self._apply(prim, "NewtonJointAPI", {"newton:velocityLimit": velocity, "newton:friction": friction})
        if friction:
            efforts = {f"physxJointAxis:{way}:{name}FrictionEffort": friction for name in ("static", "dynamic")}
            self._apply(prim, f"PhysxJointAxisAPI:{way}", efforts)

    def _apply(self, prim: Any, schema: str, values: Mapping[str, float]) -> None:
        """Apply a schema of a simulator, which usd-core does not have."""
        prim.AddAppliedSchema(schema)
        for name, value in values.items():
            prim.CreateAttribute(name, self.sdf.ValueTypeNames.Float, custom=False).Set(value)

    def _frames(self, joint: Any, offset: Vector, turn: Vector) -> None:
        """Place a joint at the origin of its child, `offset` from that of its parent, turned in both by a quaternion."""
        rotation = self.gf.Quatf(*turn.tolist())
        joint.CreateLocalPos0Attr(self._vector(offset))
        joint.CreateLocalRot0Attr(rotation)
        joint.CreateLocalPos1Attr(self._vector(np.zeros(3)))
        joint.CreateLocalRot1Attr(rotation)

    def _vector(self, values: Vector) -> Any:
        return self.gf.Vec3f(*values.tolist())
