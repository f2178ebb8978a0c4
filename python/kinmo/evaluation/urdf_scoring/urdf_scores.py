"""One URDF against one annotated shape."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.joint import Joint, JointKind
from kinmo.core.shape import Shape
from kinmo.evaluation import metrics
from kinmo.evaluation.urdf_scoring.body_matching import LEAST_IOU, Match, match
from kinmo.evaluation.urdf_scoring.frame_alignment import Similarity, align
from kinmo.evaluation.urdf_scoring.rest_bodies import RobotBody, robot_bodies
from kinmo.evaluation.urdf_scoring.sampled_surface import Surface, sampled
from kinmo.io.readers.urdf_meshes import LARGEST_NUMBER, NO_TRIANGLES, Triangles, triangles_of
from kinmo.io.readers.urdf_reader import read_robot_file

SAMPLES, LEAST_SAMPLES = 12_000, 1_000
LARGEST_RESIDUAL = 0.01
"""In diagonals: a prediction that fits worse is of another shape, or opened."""

MISSING, FAILED, SCORED = "missing", "failed", "scored"


@dataclass(frozen=True)
class PartScore:
    """One movable part of the truth. Angles in radians, lengths in diagonals; None where a figure has no meaning.

    Angle, lines, range and `limited_ok` are of found parts of the right kind only.
    """

    body: int
    name: str
    kind: JointKind
    found: bool = False
    iou: float = 0.0
    is_relative: bool = False
    link: str | None = None
    predicted_kind: JointKind | None = None
    parent_ok: bool = False
    angle: float | None = None
    line: float | None = None
    line_at_part: float | None = None
    range_iou: float | None = None
    limited_ok: bool = False

    @property
    def kind_ok(self) -> bool:
        return self.found and self.predicted_kind is self.kind

    @property
    def turns(self) -> bool:
        return self.kind is not JointKind.PRISMATIC


@dataclass(frozen=True)
class ObjectScore:
    """One object. `status` is missing, failed (`reason` says why) or scored; an object that is not scored found nothing."""

    id: str
    category: str
    status: str
    reason: str
    parts: tuple[PartScore, ...]
    false_alarms: int = 0
    residual: float | None = None


@dataclass(frozen=True, eq=False)
class _TruePart:
    """A body of the truth that has triangles; `parent` is an index into the true parts."""

    body: int
    name: str
    triangles: Triangles
    parent: int | None
    joint: Joint | None
    is_junk: bool


def score_urdf(truth: Shape, urdf: Path | None, packages: Path, least_iou: float = LEAST_IOU) -> ObjectScore:
    """Score the prediction at `urdf` (None if there is none) for the annotated shape `truth`.

    Whatever is wrong with the prediction is this object's failure, with a reason.
    """
    parts = _true_parts(truth)
    movable = tuple(PartScore(part.body, part.name, part.joint.kind) for part in parts if part.joint is not None)
    nothing = ObjectScore(truth.id, truth.category, MISSING, "no URDF", movable)
    if urdf is None:
        return nothing
    try:
        return _scored(nothing, parts, robot_bodies(read_robot_file(urdf, packages)), least_iou)
    except InputError as error:
        return replace(nothing, status=FAILED, reason=str(error))
    except (OSError, ValueError, ArithmeticError, IndexError) as error:  # files and numbers go wrong in ways not thought of
        reason = InputError(urdf, f"cannot be scored ({type(error).__name__}: {error})")
        return replace(nothing, status=FAILED, reason=str(reason))


def _true_parts(truth: Shape) -> list[_TruePart]:
    mobility = truth.mobility
    if mobility is None:
        raise InputError(truth.source, "expected a shape with a mobility")
    triangles = [
        np.concatenate([NO_TRIANGLES, *(triangles_of(m) for leaf in b.leaves if (m := truth.parts[leaf].mesh) is not None)])
        for b in mobility.bodies
    ]
    place = {body: index for index, body in enumerate(i for i, soup in enumerate(triangles) if len(soup))}
    above = [None if body.parent is None else place.get(body.parent) for body in mobility.bodies]
    return [
        _TruePart(i, body.name, triangles[i], above[i], body.joint, mobility.junk >= set(body.leaves))
        for i, body in enumerate(mobility.bodies)
        if i in place
    ]


def _scored(nothing: ObjectScore, parts: list[_TruePart], bodies: tuple[RobotBody, ...], least_iou: float) -> ObjectScore:
    rng = np.random.default_rng(0)
    junk = np.array([part.is_junk for part in parts], bool)
    if junk.all():
        raise InputError(nothing.id, "expected a truth with geometry besides junk")
    if not bodies:
        raise InputError(nothing.id, "expected a prediction with geometry")
    kept = Surface(np.concatenate([part.triangles for part in parts if not part.is_junk]), SAMPLES, rng)
    everything = Surface(np.concatenate([part.triangles for part in parts]), SAMPLES, rng) if junk.any() else kept
    predicted = Surface(np.concatenate([body.triangles for body in bodies]), SAMPLES, rng)
    if not predicted.diagonal > 1.0 / LARGEST_NUMBER:  # squares of its lengths might vanish
        raise InputError(nothing.id, "expected a prediction with geometry, found a point")
    frame = align(kept, everything, predicted)
    if not frame.residual <= LARGEST_RESIDUAL:
        raise InputError(nothing.id, f"misaligned: surfaces are {100 * frame.residual:.2f} % of the diagonal apart")
    surfaces = sampled([part.triangles for part in parts], SAMPLES, LEAST_SAMPLES, rng)
    shapes = sampled([frame.apply(body.triangles) for body in bodies], SAMPLES, LEAST_SAMPLES, rng)
    found = match(surfaces, junk, shapes, kept.diagonal, least_iou)
    scores = iter(nothing.parts)
    judged = tuple(
        _judge(next(scores), index, parts, bodies, found, frame, kept.diagonal)
        for index, part in enumerate(parts)
        if part.joint is not None
    )
    part_of = {body: part for part, body in found.body_of.items()}
    moving = {index for index, part in enumerate(parts) if part.joint is not None}
    false_alarms = sum(body.moves and part_of.get(index) not in moving for index, body in enumerate(bodies))
    return replace(nothing, status=SCORED, reason="", parts=judged, false_alarms=false_alarms, residual=frame.residual)


def _judge(
    score: PartScore,
    index: int,
    parts: list[_TruePart],
    bodies: tuple[RobotBody, ...],
    found: Match,
    frame: Similarity,
    diagonal: float,
) -> PartScore:
    part, place = parts[index], found.body_of.get(index)
    above = None if part.parent is None else found.home[part.parent]
    score = replace(score, iou=float(found.iou[index].max()))
    if place is None:
        return score
    body = bodies[place]
    score = replace(score, iou=float(found.iou[index, place]), is_relative=above is not None and above != place)
    if not body.moves:
        return score
    score = replace(score, found=True, link=body.name, parent_ok=above is not None and body.parent == above)
    assert part.joint is not None
    if body.joint is None or body.joint.kind is not part.joint.kind:
        return replace(score, predicted_kind=None if body.joint is None else body.joint.kind)
    return _compared(score, part.joint, joint_in(frame, body.joint), part.triangles, diagonal)


def joint_in(frame: Similarity, joint: Joint) -> Joint:
    """A predicted joint in the frame and the lengths of the truth."""
    unit = 1.0 if joint.kind is JointKind.REVOLUTE else frame.scale
    limits = (None, None) if joint.lower is None or joint.upper is None else (unit * joint.lower, unit * joint.upper)
    return Joint(joint.kind, frame.rotation @ joint.direction, frame.apply(joint.pivot), *limits)


def _compared(score: PartScore, true: Joint, predicted: Joint, triangles: Triangles, diagonal: float) -> PartScore:
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
