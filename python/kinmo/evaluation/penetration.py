"""How much of a moving part runs into the rest on its way through its range."""

from __future__ import annotations

import math

import numpy as np

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

REVOLUTE, PRISMATIC = 0, 1
DECIMALS = 9
"""Joints that agree to so many are swept once."""

_Sweep = tuple[tuple[int, ...], JointKind, bytes]


class PenetrationMeter:
    """Sweeps the parts of one shape through the ranges of the joints that several methods say they have.

    `meshes` are those of `leaves`, in the frame of the mobilities. What has been swept once is remembered, as methods often
    agree.
    """

    def __init__(self, meshes: _core.Meshes, leaves: tuple[int, ...]) -> None:
        self._meshes = meshes
        self._place = {leaf: index for index, leaf in enumerate(leaves)}
        self._known: dict[_Sweep, float] = {}

    def of(self, mobility: Mobility) -> dict[int, float]:
        """The share [0, 1] of surface probes that collide on the way through the joint's range, by index of the movable body.

        A body takes its descendants along; a screw is swept as a slide, an unlimited hinge half a turn either way. A body that
        nothing else is beside, or a slider without limits, has no figure.
        """
        shares: dict[int, float] = {}
        for index, body in mobility.movable():
            below = mobility.descendants(index)
            moving = tuple(sorted(self._place[leaf] for other in below for leaf in mobility.bodies[other].leaves))
            span = None if body.joint is None else _span(body.joint)
            if body.joint is not None and span is not None and 0 < len(moving) < len(self._place):
                shares[index] = self._share(moving, body.joint, span)
        return shares

    def _share(self, moving: tuple[int, ...], joint: Joint, span: tuple[float, float]) -> float:
        numbers = np.concatenate([joint.direction, joint.pivot, span]).round(DECIMALS)
        key = moving, joint.kind, numbers.tobytes()
        if key not in self._known:
            rest = [leaf for leaf in range(len(self._place)) if leaf not in set(moving)]
            self._known[key] = _swept(self._meshes, list(moving), rest, joint, span)
        return self._known[key]


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
