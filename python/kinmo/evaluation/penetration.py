"""How much of a moving part runs into the rest on its way through its range."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from kinmo import _core
from kinmo.joint import Joint, JointKind
from kinmo.mobility import Mobility
from kinmo.shape import Mesh

REVOLUTE, PRISMATIC = 0, 1


def penetrations(meshes: Iterable[Mesh], leaves: tuple[int, ...], mobility: Mobility) -> dict[int, float]:
    """The share [0, 1] of surface probes that collide on the way through the joint's range, by index of the movable body.

    `meshes` are those of `leaves`, in the frame of `mobility`. A body takes its descendants along; a screw is swept as a
    slide, an unlimited hinge half a turn either way. A body that nothing else is beside, or a slider without limits, has no
    figure.
    """
    found = list(meshes)
    core = _core.Meshes([mesh.vertices for mesh in found], [mesh.faces for mesh in found])
    place = {leaf: index for index, leaf in enumerate(leaves)}
    shares: dict[int, float] = {}
    for index, body in mobility.movable():
        moving = {place[leaf] for below in mobility.descendants(index) for leaf in mobility.bodies[below].leaves}
        rest = [other for other in range(len(found)) if other not in moving]
        span = None if body.joint is None else _span(body.joint)
        if body.joint is not None and span is not None and rest:
            shares[index] = _swept(core, sorted(moving), rest, body.joint, span)
    return shares


def _span(joint: Joint) -> tuple[float, float] | None:
    """The range from the pose of the file: at most 0 below, at least 0 above."""
    if joint.lower is None or joint.upper is None:
        return (-math.pi, math.pi) if joint.kind is JointKind.REVOLUTE else None
    return min(0.0, joint.lower - joint.rest), max(0.0, joint.upper - joint.rest)


def _swept(core: _core.Meshes, moving: list[int], rest: list[int], joint: Joint, span: tuple[float, float]) -> float:
    kind = REVOLUTE if joint.kind is JointKind.REVOLUTE else PRISMATIC
    lower, upper = (np.array([end]) for end in span)
    *_, depth = _core.sweep(
        core, moving, rest, np.array([kind], np.uint8), joint.direction[None], joint.pivot[None], lower, upper
    )
    return float(depth.max())
