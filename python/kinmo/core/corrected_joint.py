"""The joint of a body after a correction by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinmo.core.joint import KIND_WORDS, MAX_AXIS_DISTANCE, MAX_TURNS, Joint, JointKind
from kinmo.core.motion_types import CoarseType
from kinmo.core.overrides import FIXED, KIND_OF_TYPE, UNLIMITED, BodyOverride
from kinmo.core.shape import Shape, bounds_of
from kinmo.core.shape_estimate import OVERRIDE, JointEstimate


def override_estimate(joint: Joint | None) -> JointEstimate:
    """The estimate that stands for a joint given by hand, or for a body that was fixed by hand."""
    return JointEstimate(joint, CoarseType.FIXED if joint is None else CoarseType[joint.kind.value], 1.0, source=OVERRIDE)


def corrected_joint(
    override: BodyOverride, present: Joint | None, ranked: Sequence[JointEstimate], shape: Shape, leaves: Sequence[int]
) -> Joint | None:
    """The joint of a body as corrected, in the frame and the length unit of the shape. None for a fixed body.

    A new type without an alternative takes axis and range from the best ranked joint of that type. A new range starts at the
    pose of the file.

    Args:
        override: the correction.
        present: the predicted joint.
        ranked: the ranked estimates of the body, the best one first. Empty for a new body.
        shape: the shape.
        leaves: the leaves of the corrected body, as indices into `shape.parts`. They are not empty.

    Raises:
        InputError: the fields contradict each other, or the joint is not fully given.
    """
    if override.type == FIXED:
        for key in override.joint_fields:
            if key != "type":
                raise override.fail(key, "a fixed body has no joint: remove this line, or change the type")
        return None
    start = _start(override, present, ranked)
    if start is None and "alternative" in override.joint_fields and len(override.joint_fields) == 1:
        return None
    kind = _kind(override, start)
    if start is None or start.kind is not kind:
        start = next((each.joint for each in ranked if each.joint is not None and each.joint.kind is kind), None)
    if start is None:
        start = _blank(override, kind, shape, leaves)
    joint = replace(
        start,
        direction=start.direction if override.axis is None else override.axis,
        pivot=start.pivot if override.origin is None else override.origin,
    )
    if override.range is not None:
        lower, upper = _limits(override, kind, shape.diagonal)
        joint = replace(joint, lower=lower, upper=upper, rest=0.0)
    if joint.has_pivot and np.linalg.norm(joint.pivot - shape.center) > MAX_AXIS_DISTANCE * shape.diagonal:
        raise override.fail("origin", f"expected a point within {MAX_AXIS_DISTANCE:g} diagonals of the object: check the unit")
    return replace(joint, direction=-joint.direction) if override.flip else joint


def _start(override: BodyOverride, present: Joint | None, ranked: Sequence[JointEstimate]) -> Joint | None:
    """The joint that the correction starts from: the present one, or the chosen alternative."""
    rank = override.alternative
    if rank is None:
        return present
    if rank > len(ranked):
        raise override.fail("alternative", f"expected 1 to {len(ranked)}, the number of estimates of the body in joints.json")
    joint = ranked[rank - 1].joint
    words = FIXED if joint is None else KIND_WORDS[joint.kind]
    if override.type not in (None, words):
        raise override.fail("type", f"joint {rank} of the ranking is {words}: remove the type, or the alternative")
    return joint


def _kind(override: BodyOverride, start: Joint | None) -> JointKind:
    if override.type is not None:
        return KIND_OF_TYPE[override.type]
    if start is None:
        raise override.fail("type", f"needed, because the body is fixed: one of {', '.join(KIND_OF_TYPE)}")
    return start.kind


def _blank(override: BodyOverride, kind: JointKind, shape: Shape, leaves: Sequence[int]) -> Joint:
    """A joint with the given axis, where no ranked joint can complete it. The pivot of a slider is the centre of the body."""
    needed = ("axis", "range") if kind is JointKind.PRISMATIC else ("axis", "origin", "range")
    missing = [key for key in needed if getattr(override, key) is None]
    if missing:
        more = f", with {' and '.join(missing[1:])}" if len(missing) > 1 else ""
        raise override.fail(missing[0], f"needed{more}, because no ranked joint of the body is a {KIND_WORDS[kind]}")
    assert override.axis is not None
    low, high = bounds_of(shape.leaf_mesh(leaf) for leaf in leaves)
    return Joint(kind, override.axis, 0.5 * (low + high))


def _limits(override: BodyOverride, kind: JointKind, diagonal: float) -> tuple[float, float] | tuple[None, None]:
    """Lower and upper limit in radians or lengths, or None without limits."""
    if override.range == UNLIMITED or override.range is None or isinstance(override.range, str):
        return None, None
    lower, upper = override.range
    if kind is JointKind.REVOLUTE:
        if max(-lower, upper) > 360.0 * MAX_TURNS:
            raise override.fail("range", f'expected degrees within {MAX_TURNS:g} turns, or "{UNLIMITED}"')
        return math.radians(lower), math.radians(upper)
    if max(-lower, upper) > MAX_AXIS_DISTANCE * diagonal:
        most = MAX_AXIS_DISTANCE * diagonal
        raise override.fail("range", f'expected lengths of at most {most:.3g}, in the unit of the file, or "{UNLIMITED}"')
    return lower, upper
