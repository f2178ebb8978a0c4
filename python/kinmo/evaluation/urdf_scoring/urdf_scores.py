"""Scoring of one URDF against one annotated shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Shape
from kinmo.evaluation import metrics
from kinmo.evaluation.urdf_scoring.frame_alignment import Similarity, align_surfaces
from kinmo.evaluation.urdf_scoring.sampled_surface import Match, Surface, match_parts, sample_surfaces
from kinmo.io.readers.robot_bodies import NO_TRIANGLES, RobotBody, Triangles, robot_bodies
from kinmo.io.readers.robot_file import MAX_NUMBER
from kinmo.io.readers.urdf_reader import read_robot_file

SAMPLES, MIN_SAMPLES = 12_000, 1_000  # samples of a whole surface, and the fewest of one part or body
MAX_RESIDUAL = 0.01
"""Largest residual of an aligned prediction, in diagonals. One that fits worse is another shape, or an open one."""

MISSING, FAILED, SCORED = "missing", "failed", "scored"  # statuses of an object


@dataclass(frozen=True)
class PartScore:
    """The score of one movable part of the truth, the body `body` called `name`. Angles are in radians, lengths in diagonals.

    The errors (`angle`, `line`, `line_at_part`, `range_iou`) and `limited_ok` are of found parts of the right kind only.
    """

    body: int
    name: str
    kind: JointKind
    found: bool = False  # the part matches a body that moves against its parent
    iou: float = 0.0  # overlap with the matched body, or the largest overlap with any body
    is_relative: bool = False  # the matched body is not the one that holds most of the part's parent
    link: str | None = None  # name of the matched body's topmost link
    predicted_kind: JointKind | None = None  # None if the predicted joint has none of kinmo's kinds
    parent_ok: bool = False  # the body moves against the one that holds most of the true parent
    angle: float | None = None
    line: float | None = None
    line_at_part: float | None = None
    range_iou: float | None = None
    limited_ok: bool = False  # both joints are limited, or both are not

    @property
    def kind_ok(self) -> bool:
        """True for a found part with the right kind of joint."""
        return self.found and self.predicted_kind is self.kind

    @property
    def turns(self) -> bool:
        """True for hinges and screws, whose axes have a place."""
        return self.kind is not JointKind.PRISMATIC

    @property
    def is_ok(self) -> bool:
        """True for a found part with the right kind, axis and line (`metrics.is_ok`)."""
        return self.found and metrics.is_ok(self.kind, self.predicted_kind, self.angle, self.line_at_part)


@dataclass(frozen=True)
class ObjectScore:
    """The score of one object: its status with the reason of a failure, and the scores of the movable parts of the truth.

    None of the parts of an object that is not scored is found. `false_alarms` counts predicted bodies that move but match no
    movable part. `residual` is the mean distance of the aligned surfaces, in diagonals.
    """

    id: str
    category: str
    status: str
    reason: str
    parts: tuple[PartScore, ...]
    false_alarms: int = 0
    residual: float | None = None


def score_urdf(truth: Shape, urdf: Path | None, packages: Path) -> ObjectScore:
    """Score a predicted URDF, None if there is none, for an annotated shape.

    Whatever is wrong with the prediction is a failure of this object. `package://` meshes are searched up to the folder
    `packages`. Raises InputError if the truth cannot be scored against.
    """
    parts, junk = _true_parts(truth)
    movable = tuple(PartScore(body, part.name, part.joint.kind) for body, part in parts.items() if part.joint is not None)
    nothing = ObjectScore(truth.id, truth.category, MISSING, "no URDF", movable)
    if urdf is None:
        return nothing
    try:
        return _scored(nothing, tuple(parts.values()), junk, robot_bodies(read_robot_file(urdf, packages)))
    except InputError as error:
        return replace(nothing, status=FAILED, reason=str(error))
    except (OSError, ValueError, ArithmeticError, IndexError) as error:  # files and numbers may be wrong in any way
        reason = InputError(urdf, f"cannot be scored ({type(error).__name__}: {error})")
        return replace(nothing, status=FAILED, reason=str(reason))


def _true_parts(truth: Shape) -> tuple[dict[int, RobotBody], NDArray[np.bool_]]:
    """Bodies of the truth that have triangles, by their indices, and a mask of those that are junk."""
    mobility = truth.mobility
    if mobility is None:
        raise InputError(truth.source, "expected a shape with a mobility")
    triangles = [
        np.concatenate([NO_TRIANGLES, *(m.triangles for leaf in b.leaves if (m := truth.parts[leaf].mesh) is not None)])
        for b in mobility.bodies
    ]
    place = {body: index for index, body in enumerate(i for i, own in enumerate(triangles) if len(own))}
    parts = {}
    for index in place:
        body = mobility.bodies[index]
        above = None if body.parent is None else place.get(body.parent)
        parts[index] = RobotBody(body.name, triangles[index], above, body.joint, body.joint is not None)
    return parts, np.array([mobility.junk >= set(mobility.bodies[index].leaves) for index in place], bool)


def _scored(
    nothing: ObjectScore, parts: Sequence[RobotBody], junk: NDArray[np.bool_], bodies: Sequence[RobotBody]
) -> ObjectScore:
    rng = np.random.default_rng(0)
    if junk.all():
        raise InputError(nothing.id, "expected a truth with geometry besides junk")
    if not bodies:
        raise InputError(nothing.id, "expected a prediction with geometry")
    kept = Surface(np.concatenate([part.triangles for part, skip in zip(parts, junk, strict=True) if not skip]), SAMPLES, rng)
    everything = Surface(np.concatenate([part.triangles for part in parts]), SAMPLES, rng) if junk.any() else kept
    predicted = Surface(np.concatenate([body.triangles for body in bodies]), SAMPLES, rng)
    if not predicted.diagonal > 1.0 / MAX_NUMBER:  # squares of its lengths might vanish
        raise InputError(nothing.id, "expected a prediction with geometry, found a point")
    frame = align_surfaces(kept, everything, predicted)
    if not frame.residual <= MAX_RESIDUAL:
        raise InputError(nothing.id, f"misaligned: surfaces are {100 * frame.residual:.2f} % of the diagonal apart")
    surfaces = sample_surfaces([part.triangles for part in parts], SAMPLES, MIN_SAMPLES, rng)
    shapes = sample_surfaces([frame.apply(body.triangles) for body in bodies], SAMPLES, MIN_SAMPLES, rng)
    found = match_parts(surfaces, junk, shapes, kept.diagonal)
    moving = [index for index, part in enumerate(parts) if part.moves]
    scored_parts = tuple(
        _score_part(score, index, parts[index], bodies, found, frame, kept.diagonal)
        for score, index in zip(nothing.parts, moving, strict=True)
    )
    part_of = {body: part for part, body in found.body_of.items()}
    false_alarms = sum(body.moves and part_of.get(index) not in moving for index, body in enumerate(bodies))
    return replace(nothing, status=SCORED, reason="", parts=scored_parts, false_alarms=false_alarms, residual=frame.residual)


def _score_part(
    score: PartScore, index: int, part: RobotBody, bodies: Sequence[RobotBody], found: Match, frame: Similarity, diagonal: float
) -> PartScore:
    match = found.body_of.get(index)
    above = None if part.parent is None else found.home[part.parent]
    score = replace(score, iou=float(found.iou[index].max()))
    if match is None:
        return score
    body = bodies[match]
    score = replace(score, iou=float(found.iou[index, match]), is_relative=above is not None and above != match)
    if not body.moves:
        return score
    score = replace(score, found=True, link=body.name, parent_ok=above is not None and body.parent == above)
    assert part.joint is not None
    if body.joint is None or body.joint.kind is not part.joint.kind:
        return replace(score, predicted_kind=None if body.joint is None else body.joint.kind)
    return _with_errors(score, part.joint, joint_in(frame, body.joint), part.triangles, diagonal)


def joint_in(frame: Similarity, joint: Joint) -> Joint:
    """A predicted joint in the frame and the lengths of the truth; `frame` is the alignment."""
    unit = 1.0 if joint.kind is JointKind.REVOLUTE else frame.scale
    limits = (None, None) if joint.lower is None or joint.upper is None else (unit * joint.lower, unit * joint.upper)
    return Joint(joint.kind, frame.rotation @ joint.direction, frame.apply(joint.pivot), *limits)


def _with_errors(score: PartScore, true: Joint, predicted: Joint, triangles: Triangles, diagonal: float) -> PartScore:
    middle = 0.5 * (triangles.min(axis=(0, 1)) + triangles.max(axis=(0, 1)))
    has_line = true.has_pivot
    return replace(
        score,
        predicted_kind=predicted.kind,
        angle=metrics.axis_error(true.direction, predicted.direction),
        line=metrics.line_distance(true, predicted, middle) / diagonal if has_line else None,
        line_at_part=metrics.line_distance_at_part(true, predicted, middle) / diagonal if has_line else None,
        range_iou=metrics.range_iou(true, predicted),
        limited_ok=(metrics.limits(true) is None) == (metrics.limits(predicted) is None),
    )
