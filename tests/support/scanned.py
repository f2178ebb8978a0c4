"""Small articulated objects to scan, and what a network without any error would say of their scans."""

from __future__ import annotations

from collections import Counter
from dataclasses import fields

import numpy as np
from articulated import shape_of_boxes

from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Body
from kinmo.core.shape import Shape
from kinmo.evaluation.scan_metrics import truth
from kinmo.scans.ancsh.ancsh_targets import REACH, JointAxes, canonical_coordinates, layout, surroundings
from kinmo.scans.articulated_object import ArticulatedObject, Extents, articulated_object
from kinmo.scans.input_frame import InputFrame
from kinmo.scans.labelled_frames import Scans
from kinmo.scans.point_predictions import Layout, PointAnswers
from kinmo.scans.pose_fitting import ScanEstimate
from kinmo.scans.scan_file import ScanFile

ARRAYS = tuple(field.name for field in fields(Scans) if field.name != "refused")
RIGHT = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 1.0, 0.0])
FRONT = np.array([0.0, 0.0, 1.0])


def scans_in(file: ScanFile) -> Scans:
    """All frames of a file."""
    return Scans(**{name: file.read(name) for name in ARRAYS}, refused=Counter(file.refused))


def hinge(pivot: tuple[float, float, float], direction: np.ndarray = UP, lower: float = 0.0, upper: float = 1.5) -> Joint:
    return Joint(JointKind.REVOLUTE, direction, np.array(pivot), lower, upper)


def slider(direction: np.ndarray = FRONT, upper: float = 0.6) -> Joint:
    return Joint(JointKind.PRISMATIC, direction, np.zeros(3), 0.0, upper)


def screw(pivot: tuple[float, float, float], direction: np.ndarray = UP) -> Joint:
    return Joint(JointKind.SCREW, direction, np.array(pivot), 0.0, 0.3)


def cupboard() -> Shape:
    """A carcass with a door above a drawer, a knob on the door, and a lid that a screw holds; y is up, +z the front."""
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


def true_estimate(target: ArticulatedObject, scans: Scans, row: int) -> ScanEstimate:
    states = scans.poses[row], scans.values[row], scans.turns[row]
    return truth(*states, target.joints, target.structure, target.part_extents)


def true_answers(target: ArticulatedObject, scans: Scans, row: int, frame: InputFrame | None = None) -> PointAnswers:
    """What there is to say of the points of a frame."""
    frame = frame or InputFrame(np.zeros(3), 1.0)
    parts, places = scans.parts[row].astype(np.int64), scans.places[row].astype(np.float64)
    npcs, naocs = canonical_coordinates(places, parts, target.part_extents)
    near = surroundings(places[None], parts[None], JointAxes.of([target.joints]), target.structure)
    joints, heatmap, toward, axes = (each[0] for each in (near.joints, near.heatmap, near.toward, near.axes))
    extents = target.part_extents
    pivots = naocs + toward * ((1.0 - heatmap) * REACH)[:, None]
    return PointAnswers(
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


def true_layout(target: ArticulatedObject) -> Layout:
    """What there is to say of scans as wholes."""
    half_sizes, pivots = layout(Extents.stack([target.part_extents]), JointAxes.of([target.joints]))
    return Layout(half_sizes[0].astype(np.float64), pivots[0].astype(np.float64))
