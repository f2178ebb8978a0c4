"""Penetration of moving parts into the rest of the object, on the way through their ranges."""

from __future__ import annotations

import math

import numpy as np

from kinmo import _core
from kinmo.core.joint import Joint, JointKind
from kinmo.core.mobility import Mobility

REVOLUTE, PRISMATIC = 0, 1  # codes of the two kinds of motion in `_core.sweep`
DECIMALS = 9  # joints that agree to this many decimals are swept once


class PenetrationMeter:
    """Sweeps the parts of one shape through the ranges that several methods predict. Equal sweeps are computed once."""

    def __init__(self, meshes: _core.Meshes, leaves: tuple[int, ...]) -> None:
        """Measure mobilities in the frame of the meshes, one for each of the leaf parts with the indices `leaves`."""
        self._meshes = meshes
        self._index_of_leaf = {leaf: index for index, leaf in enumerate(leaves)}
        self._known: dict[tuple[tuple[int, ...], JointKind, bytes], float] = {}

    def measure(self, mobility: Mobility) -> dict[int, float]:
        """Share (0 to 1) of surface probes that collide, by index of the movable body.

        A body takes its descendants along. A screw is swept as a slide, an unlimited hinge half a turn either way. There is no
        share for a body that is all of the object, and for a slider without limits.
        """
        shares: dict[int, float] = {}
        for index, body in mobility.movable():
            below = mobility.descendants(index)
            moving = tuple(sorted(self._index_of_leaf[leaf] for other in below for leaf in mobility.bodies[other].leaves))
            span = None if body.joint is None else _sweep_range(body.joint)
            if body.joint is not None and span is not None and 0 < len(moving) < len(self._index_of_leaf):
                shares[index] = self._share(moving, body.joint, span)
        return shares

    def _share(self, moving: tuple[int, ...], joint: Joint, span: tuple[float, float]) -> float:
        numbers = np.concatenate([joint.direction, joint.pivot, span]).round(DECIMALS)
        key = moving, joint.kind, numbers.tobytes()
        if key not in self._known:
            rest = sorted(set(range(len(self._index_of_leaf))).difference(moving))
            code = np.array([REVOLUTE if joint.kind is JointKind.REVOLUTE else PRISMATIC], np.uint8)
            ends = (np.array([end]) for end in span)
            axis = joint.direction[None], joint.pivot[None]
            *_, depth = _core.sweep(self._meshes, list(moving), rest, code, *axis, *ends)
            self._known[key] = float(depth.max())
        return self._known[key]


def _sweep_range(joint: Joint) -> tuple[float, float] | None:
    """The range relative to the pose of the file: at most 0 below, at least 0 above. None for an unlimited slider."""
    if joint.lower is None or joint.upper is None:
        return (-math.pi, math.pi) if joint.kind is JointKind.REVOLUTE else None
    return min(0.0, joint.lower - joint.rest), max(0.0, joint.upper - joint.rest)
