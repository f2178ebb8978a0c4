"""Pairs of clouds: a part moved along its true joint, and along another axis of its box (paper, section 3.3)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from kinmo.config import AxisConfig
from kinmo.core.joint import Joint, JointKind
from kinmo.features.candidate_joints import Candidates
from kinmo.features.prepared_shape import PreparedShape
from kinmo.methods.paper.axis_selection.motion_clouds import SCREW_SLIDES, SCREW_TURN, SLIDES, TURNS, MarkedCloud, marked_cloud
from kinmo.methods.paper.axis_selection.negative_axes import negative_candidates

F32 = NDArray[np.float32]
F64 = NDArray[np.float64]

UNLIMITED = {
    JointKind.REVOLUTE: (-math.pi / 2, math.pi / 2),
    JointKind.PRISMATIC: (-0.25, 0.25),
    JointKind.SCREW: (-0.012, 0.013),
}
"""The range taken for joints without one: radians, or diagonals."""

JUDGED = {JointKind.REVOLUTE: TURNS, JointKind.PRISMATIC: SLIDES, JointKind.SCREW: SCREW_SLIDES}
"""Candidates are judged by these displacements, whatever a joint's range: so they are what is learnt."""

VALIDATION_ROUNDS = 2
PROBED_POINTS = 600


@dataclass(frozen=True, eq=False)
class PairBatch:
    """Clouds [B, n, 4] of B joints: as they are, moved along the true axis, and moved along a wrong one."""

    original: Tensor
    feasible: Tensor
    infeasible: Tensor

    def to(self, device: torch.device | str, non_blocking: bool = False) -> PairBatch:
        return PairBatch(*(t.to(device, non_blocking=non_blocking) for t in (self.original, self.feasible, self.infeasible)))


@dataclass(frozen=True, eq=False)
class JointSample:
    """One annotated joint: its shape, the places of the leaves that move with it, and the wrong axes."""

    shape: PreparedShape
    moving: list[int]
    name: str
    joint: Joint
    negatives: Candidates


def moving_leaves(shape: PreparedShape, body: int) -> list[int]:
    """Places in `leaves` of what moves when body `body` of the annotation does: its own leaves and its descendants'."""
    assert shape.mobility is not None
    place = {leaf: position for position, leaf in enumerate(shape.leaves)}
    along = shape.mobility.descendants(body)
    return sorted(place[leaf] for index in along for leaf in shape.mobility.bodies[index].leaves)


def joint_samples(shapes: Sequence[PreparedShape], config: AxisConfig) -> list[JointSample]:
    """All joints of annotated shapes that have something to move against and a wrong axis to be told from."""
    samples = []
    rng = np.random.default_rng(0)
    for shape in shapes:
        if shape.mobility is None or shape.body_boxes is None:
            continue
        for index, body in shape.mobility.movable():
            moving = moving_leaves(shape, index)
            assert body.joint is not None
            part = marked_cloud(
                shape.leaf_points[moving], shape.leaf_areas[moving], list(range(len(moving))), PROBED_POINTS, rng
            )
            negatives = negative_candidates(body.joint, shape.body_boxes[index], part.points, config)
            if len(negatives) and len(moving) < len(shape.leaves):
                samples.append(JointSample(shape, moving, body.name, body.joint, negatives))
    return samples


class PairData:
    """Joints drawn so that frequent names do not prevail (`AxisConfig.name_balance`), a positive and a negative pair each."""

    def __init__(self, training: Sequence[JointSample], validation: Sequence[JointSample], config: AxisConfig) -> None:
        self.training, self.config = training, config
        counts = Counter(sample.name for sample in training)
        weights = np.array([float(counts[sample.name]) ** -config.name_balance for sample in training])
        self.weights = weights / weights.sum()
        self._validation = list(self._batches([*validation] * VALIDATION_ROUNDS, np.random.default_rng(0)))

    def training_batches(self, epoch: int, rng: np.random.Generator) -> Iterator[PairBatch]:
        batches = self.config.batches_per_epoch or math.ceil(len(self.training) / self.config.batch_joints)
        drawn = rng.choice(len(self.training), batches * self.config.batch_joints, p=self.weights)
        return self._batches([self.training[i] for i in drawn], rng)

    def validation_batches(self) -> Sequence[PairBatch]:
        return self._validation

    def _batches(self, samples: Sequence[JointSample], rng: np.random.Generator) -> Iterator[PairBatch]:
        size = self.config.batch_joints
        for start in range(0, len(samples), size):
            clouds = [self._clouds(sample, rng) for sample in samples[start : start + size]]
            yield PairBatch(*(torch.from_numpy(np.stack(same)) for same in zip(*clouds, strict=True)))

    def _clouds(self, sample: JointSample, rng: np.random.Generator) -> tuple[F32, F32, F32]:
        shape, joint = sample.shape, sample.joint
        points, focus = self.config.encoder.points, self.config.focus
        cloud = marked_cloud(shape.leaf_points, shape.leaf_areas, sample.moving, points, rng, focus=focus)
        if joint.kind is not JointKind.SCREW and rng.random() < self.config.articulated:
            start = _displaced(cloud, joint.kind, joint.direction, joint.pivot, float(rng.uniform(*_range(joint))))
            cloud = replace(cloud, points=start)
        travel = float(rng.choice(JUDGED[joint.kind]))
        wrong, negatives = int(rng.integers(len(sample.negatives))), sample.negatives
        right_cloud = _displaced(cloud, joint.kind, joint.direction, joint.pivot, travel)
        wrong_cloud = _displaced(cloud, joint.kind, negatives.directions[wrong], negatives.pivots[wrong], travel)
        turn = random_turn(rng) if self.config.turned else np.eye(4, dtype=np.float32)
        return cloud.shown() @ turn, cloud.shown(right_cloud) @ turn, cloud.shown(wrong_cloud) @ turn


def random_turn(rng: np.random.Generator) -> F32:
    """One of the 48 matrices [4, 4] that take the axes to axes, mirrors among them, and leave the fourth channel as it is."""
    turn = np.zeros((4, 4), np.float32)
    turn[range(3), rng.permutation(3)] = rng.choice([-1.0, 1.0], 3)
    turn[3, 3] = 1.0
    return turn


def _displaced(cloud: MarkedCloud, kind: JointKind, direction: F64, pivot: F64, value: float) -> F32:
    angle, shift = {
        JointKind.REVOLUTE: (value, 0.0),
        JointKind.PRISMATIC: (0.0, value),
        JointKind.SCREW: (SCREW_TURN, value),
    }[kind]
    code = np.array([kind.code], np.uint8)
    moved: F32 = cloud.moved(code, direction[None], pivot[None], np.array([[angle]]), np.array([[shift]]))[0, 0]
    return moved


def _range(joint: Joint) -> tuple[float, float]:
    if joint.lower is None or joint.upper is None:
        return UNLIMITED[joint.kind]
    return joint.lower, joint.upper
