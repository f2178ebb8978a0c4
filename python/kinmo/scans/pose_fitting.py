"""From what a network says of every point of a scan to the poses of the parts, the joints and their states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from kinmo import _core
from kinmo.core.joint import JointKind
from kinmo.scans.amodal_boxes import said_boxes, seen_boxes
from kinmo.scans.articulated_object import Structure
from kinmo.scans.category_prior import Typical
from kinmo.scans.category_prior_axes import likely_directions
from kinmo.scans.input_frame import InputFrame
from kinmo.scans.point_predictions import MIDDLE, PointAnswers, said_joints

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]


@dataclass(frozen=True)
class PoseOptions:
    """`hypotheses` of the search of each part; pairs count as right within `threshold`, where the object (or
    what is seen of it) has the diagonal 1.

    `ties`: the joints tie the parts of the `tree` to each other all at once, or as in the release joint by joint (`pairs`,
    with `pair_hypotheses` of each), or not at all. `boxes`: as they are `said` to be, or with their sides where they are
    `seen`.
    """

    hypotheses: int = 10_000
    threshold: float = 0.1
    ties: Literal["tree", "pairs", "none"] = "tree"
    pair_hypotheses: int = 200
    boxes: Literal["seen", "said"] = "seen"
    seed: int = 0


@dataclass(frozen=True, eq=False)
class PartPoses:
    """Similarities of K parts from NPCS to the camera's frame; NaN for a part that was not found.

    camera = `scales` * `rotations` @ npcs + `translations`; [K], [K, 3, 3], [K, 3].
    """

    rotations: F64
    scales: F64
    translations: F64

    def apply(self, part: int, npcs: F64) -> F64:
        """Places [..., 3] in the camera's frame."""
        return np.asarray(self.scales[part] * npcs @ self.rotations[part].T + self.translations[part])

    @property
    def middles(self) -> F64:
        """Of the parts [K, 3]."""
        return np.stack([self.apply(part, MIDDLE) for part in range(len(self.scales))])

    @property
    def found(self) -> NDArray[np.bool_]:
        """[K]."""
        return np.isfinite(self.scales)


@dataclass(frozen=True, eq=False)
class ScanEstimate:
    """Parts, joints and joint states of one scan, in the camera's frame and lengths.

    `centers` and `half_extents` [K, 3] are those of the parts' amodal boxes, whose axes are the columns of the rotations;
    `inliers` [K] the shares of points that fit the pose which RANSAC found of the part alone. `directions` and `pivots` [K - 1,
    3] are the axes of the joints of parts 1 and up where they now are, `states` [K - 1] how far these are from where the
    canonical frame has them: radians, or lengths; `turns` [K - 1] are the radians of those that both slide and turn. NaN where
    unknown.
    """

    poses: PartPoses
    centers: F64
    half_extents: F64
    inliers: F64
    directions: F64
    pivots: F64
    states: F64
    turns: F64


def estimate(
    answers: Sequence[PointAnswers], structure: Structure, options: PoseOptions, typical: Typical | None = None
) -> list[ScanEstimate]:
    """Poses by RANSAC, joints by what points and the scan as a whole say, and poses again that fit them (Li 2020, section 4.3).

    What is `typical` of such objects narrows them down, where the `tree` of joints ties all parts.
    """
    if not answers:
        return []
    count = structure.part_count
    typical = typical if typical is not None and options.ties == "tree" else Typical.unknown(structure)
    clouds = [answer.on_part(part) for answer in answers for part in range(count)]
    source, target = (np.concatenate([cloud[place] for cloud in clouds]) for place in (0, 1))
    starts = np.cumsum([0, *(len(npcs) for npcs, _ in clouds)], dtype=np.int64)
    free, right = _core.find_similarities(
        source, target, starts, hypotheses=options.hypotheses, threshold=options.threshold, seed=options.seed
    )
    was_found = np.isfinite(free[1])
    shares = np.array(
        [right[a:b].mean() if found else np.nan for found, (a, b) in zip(was_found, pairwise(starts), strict=True)]
    )
    said = [said_joints(answer, structure) for answer in answers]
    likely = likely_directions(answers, [own for own, _ in said], free, structure, typical, options.threshold)
    joints = [(directions, pivots) for directions, (_, pivots) in zip(likely, said, strict=True)]
    tied = _tied(free, source, target, starts, joints, structure, options, typical)
    boxes = seen_boxes(answers, tied, options.threshold) if options.boxes == "seen" else said_boxes(answers, tied)
    estimates = []
    for frame, answer in enumerate(answers):
        own = slice(frame * count, (frame + 1) * count)
        poses = _in_camera(answer.frame, *(values[own] for values in tied))
        centers, half_extents = answer.frame.undo(boxes[0][own]), boxes[1][own] / answer.frame.scale
        found = _joints(poses, answer, joints[frame], structure, options, typical)
        estimates.append(ScanEstimate(poses, centers, half_extents, shares[own], *found))
    return estimates


def _in_camera(frame: InputFrame, rotations: F64, scales: F64, translations: F64) -> PartPoses:
    return PartPoses(frame.undo_rotations(rotations), scales / frame.scale, frame.undo(translations))


def _tied(
    free: tuple[F64, F64, F64],
    source: F64,
    target: F64,
    starts: I64,
    joints: Sequence[tuple[F64, F64]],
    structure: Structure,
    options: PoseOptions,
    typical: Typical,
) -> tuple[F64, F64, F64]:
    """The poses, those of parts that were found and that joints with known axes tie, changed to fit these."""
    if options.ties == "none":
        return free
    count = structure.part_count
    pairs, kinds, directions, turns = [], [], [], []
    for frame, (said, _) in enumerate(joints):
        for part, (kind, parent) in enumerate(zip(structure.kinds, structure.parents, strict=True), start=1):
            two = (frame * count + parent, frame * count + part)
            if np.isfinite(said[part - 1]).all() and np.isfinite(free[1][list(two)]).all():
                pairs.append(two)
                kinds.append(kind.code)
                directions.append(said[part - 1])
                turns.append(typical.turns[part - 1])
    ties = np.array(pairs, np.uint32).reshape(-1, 2), np.array(kinds, np.uint8), np.array(directions).reshape(-1, 3)
    rotations, scales, translations = (values.copy() for values in free)
    if options.ties == "tree":
        # parts that were not found have no say, and stay as they are
        lost = ~np.isfinite(scales)
        rotations[lost], scales[lost], translations[lost] = np.eye(3), 1.0, 0.0
        frames = np.arange(len(joints) + 1, dtype=np.int64) * count
        found = _core.tie_poses(
            source, target, starts, *ties, rotations, scales, translations, frames=frames, threshold=options.threshold
        )
        found = _core.settle_poses(
            source, target, starts, *ties, np.array(turns).reshape(-1, 2), np.tile(typical.square, len(joints)) & ~lost, *found,
            frames=frames, threshold=options.threshold,
        )  # fmt: skip
        for values in found:
            values[lost] = np.nan
        return found
    known = np.where(np.isfinite(scales), scales, 1.0)
    both = _core.find_tied_poses(
        source,
        target,
        starts,
        *ties,
        known,
        hypotheses=options.pair_hypotheses,
        threshold=options.threshold,
        seed=options.seed,
    )
    seen: set[int] = set()
    for row, two in enumerate(pairs):
        for place, part in enumerate(two):
            # as in the release, the first joint of a part decides where that is
            if part not in seen and np.isfinite(both[place][1][row]):
                rotations[part], translations[part] = both[place][0][row], both[place][2][row]
                seen.add(part)
    return rotations, scales, translations


def _joints(
    poses: PartPoses,
    answer: PointAnswers,
    said: tuple[F64, F64],
    structure: Structure,
    options: PoseOptions,
    typical: Typical,
) -> tuple[F64, F64, F64, F64]:
    """Directions, pivots, states and turns of the joints.

    An axis is turned as the part that it is on is, and passes where that part has it; in the `tree`, half way to where the part
    that moves has it.
    """
    directions, pivots = (np.full((structure.part_count - 1, 3), np.nan) for _ in range(2))
    states, turns = (np.full(structure.part_count - 1, np.nan) for _ in range(2))
    for row, (kind, parent) in enumerate(zip(structure.kinds, structure.parents, strict=True)):
        directions[row] = poses.rotations[parent] @ said[0][row]
        holders = [parent, row + 1] if options.ties == "tree" and poses.found[row + 1] else [parent]
        pivots[row] = np.mean([poses.apply(part, answer.on(part, said[1][row])) for part in holders], axis=0)
        if poses.found[row + 1] and poses.found[parent] and np.isfinite(said[0][row]).all():
            turn = turn_about(poses.rotations[parent].T @ poses.rotations[row + 1], said[0][row])
            turn = as_typical_turn(turn, typical.turns[row])
            slides = kind is not JointKind.REVOLUTE
            states[row] = _slide(poses, row + 1, parent, said[0][row], answer) if slides else turn
            turns[row] = turn if kind is JointKind.SCREW else np.nan
    return directions, pivots, states, turns


def _slide(poses: PartPoses, part: int, parent: int, direction: F64, answer: PointAnswers) -> float:
    # where the middle of the part is, and where it would be if it had gone along with its parent
    middle = answer.part_scales[part] * MIDDLE + answer.part_shifts[part]
    along = poses.apply(parent, answer.on(parent, middle))
    return float((poses.apply(part, MIDDLE) - along) @ (poses.rotations[parent] @ direction))


def as_typical_turn(turn: float, typical: F64) -> float:
    """The same turn with as many whole ones added as bring it nearest to the middle of the angles `typical` [2], if known."""
    middle = typical.mean()
    return turn + 2.0 * np.pi * round((middle - turn) / (2.0 * np.pi)) if np.isfinite(middle) else turn


def turn_about(rotation: F64, direction: F64) -> float:
    """The angle in (-pi, pi] about the unit vector `direction` [3] that comes nearest to `rotation` [3, 3]."""
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return float(np.pi - (np.pi - 2.0 * np.arctan2(np.dot([x, y, z], direction), w)) % (2.0 * np.pi))
