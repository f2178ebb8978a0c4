"""Small articulated objects to scan, with their true estimates and perfect network predictions."""

from __future__ import annotations

from collections import Counter
from dataclasses import fields

import numpy as np
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.evaluation.scan_metrics import true_scan_estimate
from kinmo.scans.ancsh.ancsh_targets import JOINT_RADIUS, JointAxes, canonical_coordinates, global_targets, joint_targets
from kinmo.scans.canonical.articulated_object import ArticulatedObject, articulated_object
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.object_structure import Extents
from kinmo.scans.poses.point_predictions import GlobalPredictions, PointPredictions
from kinmo.scans.poses.scan_estimate import ScanEstimate
from kinmo.scans.preprocessing.input_frame import InputFrame
from kinmo.scans.rendering.labelled_frames import LabelledFrames

ARRAYS = tuple(field.name for field in fields(LabelledFrames) if field.name != "skipped")
RIGHT = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 1.0, 0.0])
FRONT = np.array([0.0, 0.0, 1.0])


def read_frames(file: ScanFile) -> LabelledFrames:
    """All frames of a file."""
    return LabelledFrames(**{name: file.read(name) for name in ARRAYS}, skipped=Counter(file.skipped))


def hinge(pivot: tuple[float, float, float], direction: np.ndarray = UP, lower: float = 0.0, upper: float = 1.5) -> Joint:
    return Joint(JointKind.REVOLUTE, direction, np.array(pivot), lower, upper)


def slider(direction: np.ndarray = FRONT, upper: float = 0.6) -> Joint:
    return Joint(JointKind.PRISMATIC, direction, np.zeros(3), 0.0, upper)


def screw(pivot: tuple[float, float, float], direction: np.ndarray = UP) -> Joint:
    return Joint(JointKind.SCREW, direction, np.array(pivot), 0.0, 0.3)


def cupboard() -> Shape:
    """A carcass with a drawer, a door above it, a knob on the door, and a screwed lid; y is up, +z the front."""
    boxes = [
        ((-1.0, 0.0, -1.0), (1.0, 2.0, 0.9)),
        ((-1.0, 1.0, 0.9), (1.0, 2.0, 1.0)),
        ((-1.0, 0.0, 0.0), (1.0, 0.9, 1.0)),
        ((0.85, 1.4, 1.0), (0.9, 1.5, 1.05)),
        ((-0.5, 2.0, -0.5), (0.5, 2.4, 0.5)),
    ]
    bodies = [
        Body(0, "carcass", (1,)),
        Body(1, "drawer", (3,), 0, slider()),
        Body(2, "door", (2,), 0, hinge((-1.0, 0.0, 1.0), -UP)),
        Body(3, "knob", (4,), 2, hinge((0.875, 1.45, 1.0), FRONT)),
        Body(4, "lid", (5,), 0, screw((0.0, 2.0, 0.0))),
    ]
    return shape_of_boxes(boxes, bodies)


def cupboard_object() -> ArticulatedObject:
    return articulated_object(cupboard())


def true_estimate(target: ArticulatedObject, scans: LabelledFrames, row: int) -> ScanEstimate:
    states = scans.poses[row], scans.values[row], scans.turns[row]
    return true_scan_estimate(*states, target.joints, target.structure, target.part_extents)


def true_predictions(
    target: ArticulatedObject, scans: LabelledFrames, row: int, frame: InputFrame | None = None
) -> PointPredictions:
    """Predictions of perfect networks for one frame."""
    frame = frame or InputFrame(np.zeros(3), 1.0)
    parts, places = scans.parts[row].astype(np.int64), scans.places[row].astype(np.float64)
    npcs, naocs = canonical_coordinates(places, parts, target.part_extents)
    near = joint_targets(places[None], parts[None], JointAxes.of([target.joints]), target.structure)
    joints, heatmap, toward, axes = (each[0] for each in (near.joints, near.heatmap, near.toward, near.axes))
    extents = target.part_extents
    pivots = naocs + toward * ((1.0 - heatmap) * JOINT_RADIUS)[:, None]
    return PointPredictions(
        frame,
        frame.apply(scans.points[row]).astype(np.float64),
        parts,
        npcs.astype(np.float64),
        extents.diagonals,
        extents.centers + 0.5 - 0.5 * extents.diagonals[:, None],
        joints,
        axes.astype(np.float64),
        pivots.astype(np.float64),
    )


def true_global_predictions(target: ArticulatedObject) -> GlobalPredictions:
    """Predictions of a perfect network for whole scans of an object."""
    half_sizes, pivots = global_targets(Extents.stack([target.part_extents]), JointAxes.of([target.joints]))
    return GlobalPredictions(half_sizes[0].astype(np.float64), pivots[0].astype(np.float64))
