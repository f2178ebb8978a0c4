"""Mechanism: fixed pieces, and parts that move relative to them or to each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.synth_object import Motion


@dataclass(eq=False)
class MovingPart:
    """A part that moves.

    Attributes:
        name: Name of the part.
        pieces: Meshes of the part.
        motion: Joint of the part.
        parent: Part that `motion` is relative to; None for the object that carries the mechanism.
    """

    name: str
    pieces: Sequence[Mesh]
    motion: Motion
    parent: MovingPart | None = None


@dataclass(eq=False)
class Mechanism:
    """Moving and fixed parts of one mechanism.

    Attributes:
        moving: Moving parts, each after its parent.
        fixed: Pieces that become part of the object that carries the mechanism.
    """

    moving: list[MovingPart]
    fixed: list[Mesh] = field(default_factory=list)


MechanismBuilder: TypeAlias = Callable[[Draw], Mechanism]
"""Function that builds a mechanism in its unit cell."""
