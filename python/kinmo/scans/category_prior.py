"""What is usual among the objects that networks were trained on, and narrows down what a scan can show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import ScanFile

F64 = NDArray[np.float64]

ALL_BUT_FEW = (0.01, 0.99)
"""Quantiles of the states between which a joint is usually found."""
SQUARE = 0.8
"""The share of its surface from which on a part faces the axes of its coordinates: lids of pots have .74, boxes .9 and more."""
ALONG = np.cos(np.radians(5.0))
"""From this cosine on a joint is along one of the axes."""
MOSTLY = 0.9
"""The share of objects from which on a joint is said to be along one."""


@dataclass(frozen=True, eq=False)
class Typical:
    """Of objects with K parts: `turns` [K - 1, 2], the angles in radians from the canonical state between which the joints of
    parts 1 and up are found (NaN for those that do not turn, and where nothing is known); which parts are `square` [K]: their
    surfaces face the axes of NPCS; which joints are `along_axes` [K - 1] of NAOCS.
    """

    turns: F64
    square: NDArray[np.bool_]
    along_axes: NDArray[np.bool_]

    @classmethod
    def unknown(cls, structure: Structure) -> Typical:
        count = structure.part_count
        return cls(np.full((count - 1, 2), np.nan), np.zeros(count, bool), np.zeros(count - 1, bool))

    @classmethod
    def of(cls, files: Sequence[ScanFile]) -> Typical:
        """Of the scans of objects of one structure, each with a frame at least."""
        structure = files[0].structure
        turns = [_turns(files, row, kind) for row, kind in enumerate(structure.kinds)]
        shares = np.array([file.facing for file in files])
        usual = [np.median(of_part[np.isfinite(of_part)]) if np.isfinite(of_part).any() else 0.0 for of_part in shares.T]
        cosines = np.array([[np.abs(joint.direction).max() for joint in file.joints] for file in files])
        return cls(np.array(turns).reshape(-1, 2), np.array(usual) >= SQUARE, (cosines >= ALONG).mean(axis=0) >= MOSTLY)

    def to_data(self) -> dict[str, Any]:
        turns = [None if np.isnan(pair).any() else [float(angle) for angle in pair] for pair in self.turns]
        return {"turns": turns, "square": self.square.tolist(), "along_axes": self.along_axes.tolist()}

    @classmethod
    def from_data(cls, data: Mapping[str, Any], structure: Structure) -> Typical:
        """Raises KeyError, TypeError or ValueError if `to_data` did not write it for this structure."""
        turns = [(np.nan, np.nan) if pair is None else (float(pair[0]), float(pair[1])) for pair in data["turns"]]
        square, along_axes = (np.array(data[name], bool) for name in ("square", "along_axes"))
        if not len(turns) == len(along_axes) == len(square) - 1 == len(structure.kinds):
            raise ValueError(f"{len(turns)} joints and {len(square)} parts, expected those of {structure.in_words}")
        return cls(np.array(turns, np.float64).reshape(-1, 2), square, along_axes)


def _turns(files: Sequence[ScanFile], row: int, kind: JointKind) -> tuple[float, float]:
    if kind is JointKind.PRISMATIC:
        return np.nan, np.nan
    if kind is JointKind.REVOLUTE:
        states = np.concatenate([file.read("values")[:, row] - file.joints[row].rest for file in files])
    else:
        states = np.concatenate([file.read("turns")[:, row] for file in files])
    known = states[np.isfinite(states)]
    if not len(known):
        return np.nan, np.nan
    low, high = np.quantile(known, ALL_BUT_FEW)
    return float(low), float(high)
