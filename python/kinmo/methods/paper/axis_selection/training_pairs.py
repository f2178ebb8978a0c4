"""Training pairs of the axis selection network: motions along true joints and along wrong axes (paper, section 3.3).

Wrong axes are lines of the part's box that move it differently from the true joint.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from torch import Tensor

from kinmo import _core
from kinmo.config import AxisConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.core.oriented_box import Box
from kinmo.features.candidate_joints import CandidateJoints
from kinmo.features.candidate_lines import box_lines
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.paper.axis_selection.transformed_clouds import (
    SCREW_SLIDES,
    SLIDES,
    TEST_DISPLACEMENTS,
    LabelledCloud,
    angles_and_shifts,
    labelled_cloud,
)
from kinmo.methods.paper.leaf_roles import leaf_roles

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

DEFAULT_RANGE = {
    JointKind.REVOLUTE: (-math.pi / 2, math.pi / 2),
    JointKind.PRISMATIC: (-0.25, 0.25),
    JointKind.SCREW: (-0.012, 0.013),
}
"""Range of joints without limits, in radians or diagonals."""

VALIDATION_ROUNDS = 2
"""Number of pairs per validation joint."""
NEGATIVE_POINTS = 600
"""Points of a part that its negative axes are chosen with."""
PROBE_POINTS = 96
"""Number of these points that are moved; the others are the surface they are compared with."""
PROBE_DISPLACEMENTS = {
    JointKind.REVOLUTE: np.radians([-60.0, 30.0, 60.0]),
    JointKind.PRISMATIC: SLIDES[[1, 7]],
    JointKind.SCREW: SCREW_SLIDES[-1:],
}
"""Displacements that the motions of axes are compared at, in radians or diagonals."""
FULL_TOLERANCE_SIZE = 6.0
"""Parts with a half diagonal below 1 / 6 diagonals have a tolerance in proportion to their size."""


@dataclass(frozen=True, eq=False)
class PairBatch:
    """Inputs of the network for B joints, each [B, n, 4].

    Attributes:
        original: Clouds before the motion.
        feasible: Clouds after a motion along the true joint.
        infeasible: Clouds after a motion along a wrong axis.
    """

    original: Tensor
    feasible: Tensor
    infeasible: Tensor

    def to(self, device: torch.device | str) -> PairBatch:
        """The batch on a device."""
        return PairBatch(*(clouds.to(device) for clouds in vars(self).values()))


@dataclass(frozen=True, eq=False)
class JointSample:
    """One annotated joint.

    Attributes:
        shape: The shape.
        moving: Positions of the leaves that move with the joint.
        name: Name of the body.
        joint: The true joint.
        negatives: Wrong axes.
    """

    shape: PreparedShape
    moving: list[int]
    name: str
    joint: Joint
    negatives: CandidateJoints


def joint_samples(shapes: Sequence[PreparedShape], config: AxisConfig) -> list[JointSample]:
    """All joints of annotated shapes that have an obstacle and at least one wrong axis."""
    samples = []
    rng = np.random.default_rng(0)
    for shape in shapes:
        if shape.mobility is None or shape.body_boxes is None:
            continue
        roles = leaf_roles(shape, shape.mobility.bodies)
        for index, body in shape.mobility.movable():
            moving = roles[index].moving
            assert body.joint is not None
            part = labelled_cloud(
                shape.leaf_points[moving], shape.leaf_areas[moving], list(range(len(moving))), NEGATIVE_POINTS, rng
            )
            negatives = negative_axes(body.joint, shape.body_boxes[index], part.points, config)
            if len(negatives) and len(moving) < len(shape.leaves):
                samples.append(JointSample(shape, moving, body.name, body.joint, negatives))
    return samples


class PairData:
    """Batches of one positive and one negative pair per joint; joints with frequent names are drawn less often."""

    def __init__(self, training: Sequence[JointSample], validation: Sequence[JointSample], config: AxisConfig) -> None:
        self.training, self.config = training, config
        counts = Counter(sample.name for sample in training)
        weights = np.array([float(counts[sample.name]) ** -config.name_balance for sample in training])
        self.weights = weights / weights.sum()
        self._validation = list(self._batches([*validation] * VALIDATION_ROUNDS, np.random.default_rng(0)))

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[PairBatch]:
        """Batches of one epoch, drawn anew."""
        batches = self.config.batches_per_epoch or math.ceil(len(self.training) / self.config.batch_joints)
        drawn = rng.choice(len(self.training), batches * self.config.batch_joints, p=self.weights)
        return self._batches([self.training[i] for i in drawn], rng)

    def validation_batches(self) -> Sequence[PairBatch]:
        """Batches of the validation joints, the same in every epoch."""
        return self._validation

    def _batches(self, samples: Sequence[JointSample], rng: np.random.Generator) -> Iterator[PairBatch]:
        size = self.config.batch_joints
        for start in range(0, len(samples), size):
            clouds = [self._clouds(sample, rng) for sample in samples[start : start + size]]
            yield PairBatch(*(torch.from_numpy(np.stack(same)) for same in zip(*clouds, strict=True)))

    def _clouds(self, sample: JointSample, rng: np.random.Generator) -> tuple[F32, F32, F32]:
        """Original, feasible and infeasible cloud of one joint."""
        shape, joint = sample.shape, sample.joint
        points, focus = self.config.encoder.points, self.config.focus
        cloud = labelled_cloud(shape.leaf_points, shape.leaf_areas, sample.moving, points, rng, focus=focus)
        if joint.kind is not JointKind.SCREW and rng.random() < self.config.articulated:
            start = _moved(cloud, joint.kind, joint.direction, joint.pivot, float(rng.uniform(*_range(joint))))
            cloud = replace(cloud, points=start)
        value = float(rng.choice(TEST_DISPLACEMENTS[joint.kind]))
        wrong, negatives = int(rng.integers(len(sample.negatives))), sample.negatives
        feasible = _moved(cloud, joint.kind, joint.direction, joint.pivot, value)
        infeasible = _moved(cloud, joint.kind, negatives.directions[wrong], negatives.pivots[wrong], value)
        turn = random_axis_permutation(rng) if self.config.turned else np.eye(4, dtype=np.float32)
        return cloud.network_input() @ turn, cloud.network_input(feasible) @ turn, cloud.network_input(infeasible) @ turn


def random_axis_permutation(rng: np.random.Generator) -> F32:
    """One of the 48 matrices [4, 4] that permute and mirror the coordinate axes; the label's channel stays."""
    turn = np.zeros((4, 4), np.float32)
    turn[range(3), rng.permutation(3)] = rng.choice([-1.0, 1.0], 3)
    turn[3, 3] = 1.0
    return turn


def _moved(cloud: LabelledCloud, kind: JointKind, direction: F64, pivot: F64, value: float) -> F32:
    """Points of a cloud after one displacement."""
    code, motion = np.array([kind.code], np.uint8), angles_and_shifts(kind, np.array([[value]]))
    return np.asarray(cloud.transformed(code, direction[None], pivot[None], *motion)[0, 0])


def _range(joint: Joint) -> tuple[float, float]:
    """Limits of a joint, or the default range of its kind."""
    if joint.lower is None or joint.upper is None:
        return DEFAULT_RANGE[joint.kind]
    return joint.lower, joint.upper


def negative_axes(joint: Joint, box: Box, part: F32, config: AxisConfig) -> CandidateJoints:
    """Axes of a part's box that are infeasible for its true joint; `part` [m, 3] are points of the part.

    A hinge has the 12 edges, a slider or screw the 3 centre lines.
    Axes within `near_angle` and `near_distance` of the true axis are left out. Axes with the same motion, to within
    `same_motion` diagonals (less for small parts), are left out too: other edges of the hinge side, axes of the same symmetry.
    """
    directions, pivots, is_edge = box_lines(box)
    wanted = is_edge if joint.kind is JointKind.REVOLUTE else ~is_edge
    directions, pivots = directions[wanted], pivots[wanted]
    parallel = np.abs(directions @ joint.direction) > math.cos(math.radians(config.near_angle))
    offset = pivots - joint.pivot
    distance = np.linalg.norm(offset - (offset @ joint.direction)[:, None] * joint.direction, axis=1)
    differs = ~(parallel & ((distance < config.near_distance) | (joint.kind is JointKind.PRISMATIC)))
    if not differs.any():
        return CandidateJoints.empty()
    directions, pivots = directions[differs], pivots[differs]
    difference = motion_difference(joint, directions, pivots, part)
    tolerance = config.same_motion * min(1.0, FULL_TOLERANCE_SIZE * float(np.linalg.norm(box.half_extents)))
    directions, pivots = directions[difference > tolerance], pivots[difference > tolerance]
    count = len(directions)
    return CandidateJoints(np.full(count, joint.kind.code, np.uint8), directions, pivots, ("box",) * count)


def motion_difference(joint: Joint, directions: F64, pivots: F64, part: F32) -> F64:
    """Mean distance [C] between a part [m, 3] moved by its true joint and moved along each axis, in its better sense.

    The mean distance of samples at rest is subtracted: they lie apart even where surfaces coincide.
    """
    probes, rest = part[:PROBE_POINTS], part[PROBE_POINTS:]
    if len(rest) == 0:
        probes = rest = part
    surface = cKDTree(rest)
    angles, shifts = angles_and_shifts(joint.kind, PROBE_DISPLACEMENTS[joint.kind])
    code = np.array([joint.kind.code], np.uint8)
    moved = _core.move_points(probes, code, joint.direction[None], joint.pivot[None], angles[None], shifts[None])[0]
    codes, axes, places = np.repeat(code, 2 * len(directions)), np.tile(directions, (2, 1)), np.tile(pivots, (2, 1))
    sense = np.repeat([1.0, -1.0], len(directions))[:, None]
    gaps = []
    for cloud, angle, shift in zip(moved, angles, shifts, strict=True):
        # Moving the true cloud back along each axis needs one search tree, moving the part forward would need one per axis.
        back = _core.move_points(cloud, codes, axes, places, -angle * sense, -shift * sense)
        gaps.append(surface.query(back.reshape(-1, 3))[0].reshape(len(codes), -1).mean(axis=1))
    differences = np.mean(gaps, axis=0) - surface.query(probes)[0].mean()
    return np.asarray(np.maximum(differences.reshape(2, -1).min(axis=0), 0.0))
