"""The USD writer: a valid articulation that moves as kinmo says, with all parts at their place."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from articulated import articulated_shapes, box_mesh, shape_of_boxes
from hypothesis import given, settings
from pxr import Gf, Kind, Usd, UsdGeom, UsdPhysics, UsdUtils, UsdValidation

import kinmo
from kinmo.core.errors import InputError
from kinmo.core.frames import quaternion, z_up_rotation
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body, Mobility
from kinmo.core.shape import Mesh, Shape
from kinmo.evaluation.simulation.expected_kinematics import expected_kinematics
from kinmo.io.writers import ExportOptions, export, write_formats
from kinmo.io.writers.usd_frames import axis_frame, principal_inertia
from kinmo.robot.physics import Physics
from kinmo.robot.robot_builder import build_robot

UPS = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.0, 0.8))
STATES = 100


def written(shape: Shape, folder: Path, **options: object) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    settings = ExportOptions(**{"collision": "none", **options})
    return write_formats(shape, shape.mobility, folder, ["usd"], settings)["usd"]


def opened(path: Path) -> Usd.Stage:
    """The stage, which USD opens without a warning."""
    delegate = UsdUtils.CoalescingDiagnosticDelegate()
    stage = Usd.Stage.Open(str(path))
    assert [found.commentary for found in delegate.TakeUncoalescedDiagnostics()] == []
    return stage


def joint_prims(stage: Usd.Stage) -> list[Usd.Prim]:
    return [prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)]


def stage_motions(stage: Usd.Stage, values: dict[str, float]) -> dict[str, np.ndarray]:
    """Motion of every body from the pose of the file, from the frames of joints alone. Matrices of Gf multiply rows."""
    moved: dict[str, Gf.Matrix4d] = {}
    pending = joint_prims(stage)
    while pending:
        prim = pending.pop(0)
        joint = UsdPhysics.Joint(prim)
        (parent,), (child,) = joint.GetBody0Rel().GetTargets(), joint.GetBody1Rel().GetTargets()
        above = Gf.Matrix4d(1.0) if parent == stage.GetDefaultPrim().GetPath() else moved.get(parent.name)
        if above is None:
            pending.append(prim)
            continue
        free = Gf.Matrix4d(1.0)
        value = values.get(prim.GetName(), 0.0)
        if prim.IsA(UsdPhysics.RevoluteJoint):
            axis = Gf.Vec3d(*(float(name == UsdPhysics.RevoluteJoint(prim).GetAxisAttr().Get()) for name in "XYZ"))
            free.SetRotate(Gf.Rotation(axis, math.degrees(value)))
        elif prim.IsA(UsdPhysics.PrismaticJoint):
            axis = Gf.Vec3d(*(float(name == UsdPhysics.PrismaticJoint(prim).GetAxisAttr().Get()) for name in "XYZ"))
            free.SetTranslate(value * axis)
        frames = []
        for place, turn in (
            (joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            (joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        ):
            frame = Gf.Matrix4d().SetRotate(Gf.Quatd(turn.Get()).GetNormalized())
            frames.append(frame.SetTranslateOnly(Gf.Vec3d(place.Get())))
        moved[child.name] = frames[1].GetInverse() * free * frames[0] * above
    still = stage_motions(stage, {}) if values else {}
    columns = {name: np.array(matrix).T for name, matrix in moved.items()}
    return {name: pose @ np.linalg.inv(still[name]) if values else pose for name, pose in columns.items()}


@settings(max_examples=10, deadline=None)
@given(articulated_shapes(ups=UPS))
def test_the_joints_of_the_stage_move_every_link_as_kinmo_does(tmp_path_factory, shape):
    bodies = (b if b.joint is None else replace(b, joint=replace(b.joint, rest=0.1 * b.id)) for b in shape.mobility.bodies)
    shape = replace(shape, mobility=Mobility(tuple(bodies)))
    scale = 0.2
    stage = opened(written(shape, tmp_path_factory.mktemp("usd"), metres_per_unit=scale))
    kinematics = expected_kinematics(shape.mobility, np.array(shape.up), scale)
    names = [prim.GetName() for prim in joint_prims(stage) if not prim.IsA(UsdPhysics.FixedJoint)]
    rng = np.random.default_rng(0)
    for _ in range(STATES if names else 0):
        values = {name: float(rng.uniform(-1.0, 1.0)) for name in names}
        expected, moved = kinematics(values), stage_motions(stage, values)
        for link, pose in expected.items():
            assert np.abs(moved[link] - pose).max() < 1e-6


@settings(max_examples=10, deadline=None)
@given(articulated_shapes(ups=UPS))
def test_usd_finds_no_error_and_all_parts_are_at_their_place(tmp_path_factory, shape):
    path = written(shape, tmp_path_factory.mktemp("usd"), collision="convex")
    stage = opened(path)
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    assert "usdPhysicsValidators:ArticulationChecker" in [each.GetMetadata().name for each in validators]
    assert [error.GetMessage() for error in UsdValidation.ValidationContext(validators).Validate(stage)] == []
    rotation = z_up_rotation(np.array(shape.up))
    again = kinmo.load(path)
    assert again.up == (0.0, 0.0, 1.0) and again.metres_per_unit == 1.0
    assert sorted(again.parts[leaf].name for leaf in again.leaves) == sorted(shape.parts[leaf].name for leaf in shape.leaves)
    meshes = {again.parts[leaf].name: again.leaf_mesh(leaf) for leaf in again.leaves}
    for leaf in shape.leaves:
        found, mesh = meshes[shape.parts[leaf].name], shape.leaf_mesh(leaf)
        assert np.array_equal(found.faces, mesh.faces)
        assert found.vertices == pytest.approx(mesh.vertices @ rotation.T, abs=1e-6)


def cabinet(joint: Joint, **options: object) -> Shape:
    """A cabinet with a door on `joint` and a handle that is fixed to the door."""
    boxes = [((0, 0, 0), (1, 2, 1)), ((0, 0, 1.01), (1, 2, 1.1)), ((0.8, 1, 1.1), (0.9, 1.1, 1.2))]
    bodies = (Body(0, "body", (1,)), Body(1, "door", (2,), 0, joint), Body(2, "handle", (3,), 1))
    return shape_of_boxes(boxes, bodies, **options)


def hinge(*limits: float) -> Joint:
    return Joint(JointKind.REVOLUTE, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), *limits)


def test_the_stage_is_an_articulation_that_is_fixed_to_the_world(tmp_path):
    stage = opened(written(cabinet(hinge(0.0, 1.5)), tmp_path))
    root = stage.GetDefaultPrim()
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdPhysics.GetStageKilogramsPerUnit(stage) == 1.0
    assert root.HasAPI(UsdPhysics.ArticulationRootAPI) and Usd.ModelAPI(root).GetKind() == Kind.Tokens.component
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert [prim.GetName() for prim in bodies] == ["base", "door"]
    fixed, moving = joint_prims(stage)
    assert fixed.IsA(UsdPhysics.FixedJoint) and moving.IsA(UsdPhysics.RevoluteJoint)
    assert UsdPhysics.Joint(fixed).GetBody1Rel().GetTargets() == [bodies[0].GetPath()]
    ends = UsdPhysics.Joint(moving).GetBody0Rel().GetTargets() + UsdPhysics.Joint(moving).GetBody1Rel().GetTargets()
    assert ends == [prim.GetPath() for prim in bodies]


@pytest.mark.parametrize(
    ("kind", "limits", "unit"),
    [
        (JointKind.REVOLUTE, (-0.5, 1.5), 180.0 / math.pi),
        (JointKind.REVOLUTE, (None, None), 180.0 / math.pi),
        (JointKind.PRISMATIC, (0.0, 0.5), 1.0),
    ],
)
def test_angles_of_joints_are_degrees_and_lengths_metres(tmp_path, kind, limits, unit):
    physics = Physics(damping=0.3, friction=0.2, effort=7.0, velocity=2.0)
    shape = cabinet(Joint(kind, np.array([0.0, 1, 0]), np.array([0.0, 0, 1]), *limits))
    stage = opened(written(shape, tmp_path, physics=physics))
    prim = joint_prims(stage)[1]
    schema = UsdPhysics.PrismaticJoint if kind is JointKind.PRISMATIC else UsdPhysics.RevoluteJoint
    low, high = schema(prim).GetLowerLimitAttr(), schema(prim).GetUpperLimitAttr()
    if limits[0] is None:
        assert low.Get() == -math.inf and high.Get() == math.inf
    else:
        assert (low.Get(), high.Get()) == pytest.approx((unit * limits[0], unit * limits[1]))
    way = "linear" if kind is JointKind.PRISMATIC else "angular"
    drive = UsdPhysics.DriveAPI(prim, way)
    assert drive.GetDampingAttr().Get() == pytest.approx(0.3 / unit) and drive.GetStiffnessAttr().Get() == 0.0
    assert drive.GetMaxForceAttr().Get() == 7.0
    for name in ("physxJoint:maxJointVelocity", "newton:velocityLimit"):
        assert prim.GetAttribute(name).Get() == pytest.approx(2.0 * unit)
    for name in (f"physxJointAxis:{way}:staticFrictionEffort", "newton:friction"):
        assert prim.GetAttribute(name).Get() == pytest.approx(0.2)


def test_every_link_has_its_mass_and_inertia(tmp_path):
    turned = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    shape = cabinet(hinge(0.0, 1.0)).rotated(turned)
    stage = opened(written(shape, tmp_path))
    for link in build_robot(shape, shape.mobility).links:
        prim = stage.GetPrimAtPath(stage.GetDefaultPrim().GetPath().AppendPath(f"Geometry/{link.name}"))
        mass = UsdPhysics.MassAPI(prim)
        assert mass.GetMassAttr().Get() == pytest.approx(link.inertial.mass)
        assert np.array(mass.GetCenterOfMassAttr().Get()) == pytest.approx(link.inertial.center - link.origin, abs=1e-6)
        axes = np.array(Gf.Matrix3d(Gf.Quatd(mass.GetPrincipalAxesAttr().Get()))).T
        inertia = axes @ np.diag(mass.GetDiagonalInertiaAttr().Get()) @ axes.T
        assert inertia == pytest.approx(link.inertial.inertia, rel=1e-4, abs=1e-4)


def test_collision_geometry_is_boxes_and_hulls_that_are_not_drawn(tmp_path):
    corners = box_mesh((0, 0, 2), (1, 1, 3)).vertices[[0, 1, 2, 4]]
    tip = Mesh(corners, np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]], np.uint32))
    slider = Joint(JointKind.PRISMATIC, np.array([0.0, 0, 1]), np.zeros(3), 0.0, 1.0)
    bodies = (Body(0, "body", (1,)), Body(1, "tip", (2,), 0, slider))
    shape = shape_of_boxes([((0, 0, 0), (1, 2, 1)), ((0, 0, 2), (1, 1, 3))], bodies)
    shape = replace(shape, parts=(*shape.parts[:2], replace(shape.parts[2], mesh=tip)))
    stage = opened(written(shape, tmp_path, collision="convex"))
    box, hull = (prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI))
    assert (box.GetTypeName(), hull.GetTypeName()) == ("Cube", "Mesh")
    assert UsdPhysics.MeshCollisionAPI(hull).GetApproximationAttr().Get() == UsdPhysics.Tokens.convexHull
    links = stage.GetDefaultPrim().GetPath().AppendChild("Geometry")
    for collision, part in ((box, "base/visuals/part_0"), (hull, "tip/visuals/part_1")):
        assert UsdGeom.Imageable(collision).ComputePurpose() == UsdGeom.Tokens.guide
        drawn = bounds(stage.GetPrimAtPath(links.AppendPath(part)), UsdGeom.Tokens.default_)
        assert bounds(collision, UsdGeom.Tokens.guide) == pytest.approx(drawn, abs=1e-5)


def bounds(prim: Usd.Prim, purpose: str) -> np.ndarray:
    """The corners [2, 3] of the box around a prim in the world."""
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [purpose]).ComputeWorldBound(prim).ComputeAlignedRange()
    return np.array([box.GetMin(), box.GetMax()])


def test_names_are_identifiers_and_those_of_the_source_are_kept(tmp_path):
    names = {1: "Schränke <1>", 2: "door/left", 3: "3"}
    stage = opened(written(cabinet(hinge(0.0, 1.0), names=names), tmp_path))
    meshes = {prim.GetName(): prim.GetDisplayName() for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
    assert meshes == {"Schranke_1": "Schränke <1>", "door_left": "door/left", "part_3": "3"}


def test_a_joint_may_have_the_name_of_the_one_that_fixes_the_base(tmp_path):
    shape = cabinet(hinge(0.0, 1.0))
    bodies = [replace(body, name="fixed_base") if body.name == "door" else body for body in shape.mobility.bodies]
    stage = opened(written(replace(shape, mobility=Mobility(tuple(bodies))), tmp_path))
    assert len({prim.GetName() for prim in joint_prims(stage)}) == 2


def test_the_same_object_gives_the_same_file_in_any_folder(tmp_path):
    shape = cabinet(hinge(0.0, 1.0))
    first = written(shape, tmp_path / "plain").read_bytes()
    assert written(shape, tmp_path / "[1] :SDF_FORMAT_ARGS: ü").read_bytes() == first


def test_without_usd_core_one_line_says_how_to_get_it(tmp_path, monkeypatch):
    def without_usd(name):
        raise ImportError(name)

    monkeypatch.setattr("kinmo.io.readers.optional_library.import_module", without_usd)
    shape = cabinet(hinge(0.0, 1.0))
    with pytest.raises(InputError, match=r"^formats: USD needs usd-core: pip install 'kinmo\[usd\]' to write it$"):
        export(shape, shape.mobility, tmp_path / "out", ["urdf", "usd"])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, -1, 0], [0, 0, -1], [0.6, 0, -0.8], [-0.5, 0.5, 0.5**0.5]])
def test_the_axis_of_a_frame_is_that_of_the_joint(axis):
    name, turn = axis_frame(np.array(axis, float))
    rotation = np.array(Gf.Matrix3d(Gf.Quatd(*turn.tolist()))).T
    assert rotation[:, "XYZ".index(name)] == pytest.approx(np.array(axis, float), abs=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_inertia_is_diagonal_along_its_principal_axes():
    turn = np.array([[0.0, -1.0, 0.0], [0.8, 0.0, -0.6], [0.6, 0.0, 0.8]])
    inertia = turn @ np.diag([3.0, 1.0, 2.5]) @ turn.T
    moments, axes = principal_inertia(inertia)
    rotation = np.array(Gf.Matrix3d(Gf.Quatd(*axes.tolist()))).T
    assert rotation @ np.diag(moments) @ rotation.T == pytest.approx(inertia)
    assert principal_inertia(np.diag([3.0, 1.0, 2.0]))[1].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert quaternion(np.eye(3)).tolist() == [1.0, 0.0, 0.0, 0.0]
