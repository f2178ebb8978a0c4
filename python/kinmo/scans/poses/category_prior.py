"""Category prior: regularities of the objects that networks were trained on, which constrain pose fitting."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind
from kinmo.scans.files.scan_file import ScanFile
from kinmo.scans.object_structure import Structure

F64 = NDArray[np.float64]

TURN_QUANTILES = (0.01, 0.99)
"""Quantiles of joint states that bound the usual range."""
MIN_ALIGNED_SHARE = 0.8
"""Axis-aligned share of its surface from which on a part is axis-aligned. Lids of pots have 0.74, boxes 0.9 and more."""
MIN_ALONG_COSINE = np.cos(np.radians(5.0))
"""Cosine from which on a joint is along an axis."""
MIN_ALONG_SHARE = 0.9
"""Share of objects from which on a joint of the category is along an axis."""


@dataclass(frozen=True, eq=False)
class CategoryPrior:
    """Regularities of a category's objects with K parts.

    Attributes:
        turn_ranges: Usual ranges [K - 1, 2] of the joints' angles from the canonical pose, rad. They are NaN for joints that do
            not turn, and if unknown.
        axis_aligned: Mask [K] of the parts whose surfaces face the axes of NPCS.
        along_axes: Mask [K - 1] of the joints that are along an axis of NAOCS.
    """

    turn_ranges: F64
    axis_aligned: NDArray[np.bool_]
    along_axes: NDArray[np.bool_]

    @classmethod
    def uninformative(cls, structure: Structure) -> CategoryPrior:
        """Prior that constrains nothing."""
        count = structure.part_count
        return cls(np.full((count - 1, 2), np.nan), np.zeros(count, bool), np.zeros(count - 1, bool))

    @classmethod
    def from_scans(cls, files: Sequence[ScanFile]) -> CategoryPrior:
        """Prior of objects of one structure, from files with at least one frame each."""
        structure = files[0].structure
        turns = [_turn_range(files, row, kind) for row, kind in enumerate(structure.kinds)]
        shares = np.array([file.axis_aligned_shares for file in files])
        usual = [np.median(of_part[np.isfinite(of_part)]) if np.isfinite(of_part).any() else 0.0 for of_part in shares.T]
        cosines = np.array([[np.abs(joint.direction).max() for joint in file.joints] for file in files])
        along_axes = (cosines >= MIN_ALONG_COSINE).mean(axis=0) >= MIN_ALONG_SHARE
        return cls(np.array(turns).reshape(-1, 2), np.array(usual) >= MIN_ALIGNED_SHARE, along_axes)

    def to_data(self) -> dict[str, Any]:
        """Plain data for JSON, which `from_data` reads."""
        turns = [None if np.isnan(pair).any() else [float(angle) for angle in pair] for pair in self.turn_ranges]
        return {"turn_ranges": turns, "axis_aligned": self.axis_aligned.tolist(), "along_axes": self.along_axes.tolist()}

    @classmethod
    def from_data(cls, data: Mapping[str, Any], structure: Structure) -> CategoryPrior:
        """Prior from the data of `to_data`; KeyError, TypeError or ValueError if it is none of objects with this structure."""
        turns = [(np.nan, np.nan) if pair is None else (float(pair[0]), float(pair[1])) for pair in data["turn_ranges"]]
        axis_aligned, along_axes = (np.array(data[name], bool) for name in ("axis_aligned", "along_axes"))
        if not len(turns) == len(along_axes) == len(axis_aligned) - 1 == len(structure.kinds):
            raise ValueError(f"{len(turns)} joints and {len(axis_aligned)} parts, expected those of {structure.in_words}")
        return cls(np.array(turns, np.float64).reshape(-1, 2), axis_aligned, along_axes)


def _turn_range(files: Sequence[ScanFile], row: int, kind: JointKind) -> tuple[float, float]:
    """Usual range of a joint's angle; NaN for sliders and without states."""
    if kind is JointKind.PRISMATIC:
        return np.nan, np.nan
    if kind is JointKind.REVOLUTE:
        states = np.concatenate([file.read("values")[:, row] - file.joints[row].rest for file in files])
    else:
        states = np.concatenate([file.read("turns")[:, row] for file in files])
    known = states[np.isfinite(states)]
    if not len(known):
        return np.nan, np.nan
    low, high = np.quantile(known, TURN_QUANTILES)
    return float(low), float(high)
