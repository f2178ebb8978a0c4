"""The common interface of the simulators that exported objects are tested in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from kinmo.core.kinematics import Pose
from kinmo.core.vector import Vector


class LoadError(Exception):
    """A file that a simulator does not load, or loads with a warning. The message is the simulator's own."""


@dataclass(frozen=True)
class SimulatedJoint:
    """A joint with one degree of freedom, as a simulator loaded it.

    Attributes:
        name: Its name in the file.
        is_angle: True for a rotation in radians, False for a translation in metres.
        limits: Least and largest value. None for an endless rotation.
    """

    name: str
    is_angle: bool
    limits: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class RestRecord:
    """The motion of an object by itself, with gravity, all its joints free, and its base fixed.

    Attributes:
        values: [J] joint values at the end.
        gravity: [J] generalised force of gravity at the start, N or N m.
        fastest: Largest speed of the origin of a link at any time, m/s.
        penetration: Deepest penetration of two links at the end, m.
        is_finite: False if a value became infinite or no number.
    """

    values: Vector
    gravity: Vector
    fastest: float
    penetration: float
    is_finite: bool


class Simulator(Protocol):
    """One exported object in a simulator, with its base fixed in the world."""

    @property
    def joints(self) -> Sequence[SimulatedJoint]:
        """The joints that can move. Their values are zero in the pose of the file."""

    def link_poses(self, values: Vector) -> Mapping[str, Pose]:
        """Poses [4, 4] of links by name at joint values [J], in the world. Links that are welded together may be missing."""

    def rest(self, seconds: float) -> RestRecord:
        """Simulate the object from the pose of the file."""

    def drive(self, joint: int, targets: tuple[float, float], seconds: float) -> tuple[float, float]:
        """Drive one joint from its value 0 to both targets in turn, while the others are held.

        Returns:
            The least and the largest value that it reached.
        """
