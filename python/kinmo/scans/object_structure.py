"""Kinematic structure and part boxes of an articulated object, shared by scans, networks and evaluation."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinmo.core.joint import JointKind

F64 = NDArray[np.float64]


@dataclass(frozen=True)
class Structure:
    """Kinematic structure of an object: the joint kind and the parent of each part.

    Part 0 is the base. `kinds[i]` is the joint kind of part i + 1, and `parents[i]` is the part that it moves against.
    """

    kinds: tuple[JointKind, ...]
    parents: tuple[int, ...]

    @classmethod
    def parse(cls, joints: Sequence[str]) -> Structure:
        """Read a structure from one text per part, from part 1 on, such as `R on 0`; ValueError for any other text."""
        kinds, parents = [], []
        for part, text in enumerate(joints, start=1):
            found = re.fullmatch(rf"({'|'.join(JointKind)}) on (\d+)", text)
            if found is None or int(found[2]) >= part:
                raise ValueError(f"expected {', '.join(JointKind)} on a part before part {part}, such as R on 0, got {text!r}")
            kinds.append(JointKind(found[1]))
            parents.append(int(found[2]))
        return cls(tuple(kinds), tuple(parents))

    @property
    def part_count(self) -> int:
        """Number of parts, base included."""
        return len(self.kinds) + 1

    def __str__(self) -> str:
        joints = (f"{kind.value} on {parent}" for kind, parent in zip(self.kinds, self.parents, strict=True))
        return f"{self.part_count} parts ({', '.join(joints)})"

    @property
    def in_words(self) -> str:
        """Text for messages, such as `2 parts (revolute on part 0)`."""
        joints = (f"{kind.name.lower()} on part {parent}" for kind, parent in zip(self.kinds, self.parents, strict=True))
        return f"{self.part_count} parts ({', '.join(joints)})"


@dataclass(frozen=True, eq=False)
class Extents:
    """Axis-aligned boxes in the normalised frame: `centers` and `sizes` [..., N, 3]."""

    centers: F64
    sizes: F64

    @classmethod
    def stack(cls, extents: Sequence[Extents]) -> Extents:
        """Stack the boxes of B objects with N parts each to [B, N, 3]."""
        return cls(np.stack([each.centers for each in extents]), np.stack([each.sizes for each in extents]))

    @cached_property
    def diagonals(self) -> F64:
        """Lengths [..., N] of the boxes' diagonals."""
        return np.asarray(np.linalg.norm(self.sizes, axis=-1))
