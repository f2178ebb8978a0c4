"""What a mechanism is: pieces that stay, and parts that move against them or against each other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from kinmo.core.shape import Mesh
from kinmo.synth.draw import Draw
from kinmo.synth.model import Motion


@dataclass(eq=False)
class Moving:
    """A part that moves against part `on`, or against what the mechanism is mounted on."""

    name: str
    pieces: Sequence[Mesh]
    motion: Motion
    on: Moving | None = None


@dataclass(eq=False)
class Mechanism:
    """`moving` has what carries a part before the part; `fixed` are pieces of the mount."""

    moving: list[Moving]
    fixed: list[Mesh] = field(default_factory=list)


Builder: TypeAlias = Callable[[Draw], Mechanism]
