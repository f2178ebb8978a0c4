"""The common interface of all writers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.mobility import Mobility
from kinmo.core.shape import Shape
from kinmo.core.shape_estimate import PredictionProvenance, ShapeEstimate
from kinmo.core.wording import clean_text
from kinmo.robot.collision_geometry import COLLISION_MODES, CollisionMode
from kinmo.robot.physics import Physics
from kinmo.robot.robot import Robot
from kinmo.robot.robot_builder import build_robot


def is_file_name(name: str) -> bool:
    """True for a name of one file or folder, which leads nowhere else."""
    return name not in ("", ".", "..") and not any(c in name for c in "/\\\0")


@dataclass(frozen=True)
class ExportOptions:
    """Settings of an export. Each writer uses those that its format needs.

    Attributes:
        name: file name of the model, without ending.
        metres_per_unit: length of one unit of the shape's file, in metres.
        meta: facts to add to the metadata of the format.
        provenance: the models and settings that made the prediction.
        formats: all formats of the export, keys of `kinmo.io.writers.WRITERS`.
        collision: how parts collide in a simulator.
        physics: density of parts, and constants of joints.
        package: ROS package that holds the files: URDFs name them as package://<package>/.... Empty for relative paths.
    """

    name: str = "model"
    metres_per_unit: float = 1.0
    meta: Mapping[str, Any] = field(default_factory=dict)
    provenance: PredictionProvenance = field(default_factory=PredictionProvenance)
    formats: tuple[str, ...] = ()
    collision: CollisionMode = "convex"
    physics: Physics = field(default_factory=Physics)
    package: str = ""

    def __post_init__(self) -> None:
        if not is_file_name(self.name):
            raise InputError("name", f"expected a file name without folders, got {clean_text(self.name) or 'nothing'}")
        if self.collision not in COLLISION_MODES:
            given, modes = clean_text(str(self.collision)), ", ".join(COLLISION_MODES)
            raise InputError("collision", f"expected one of {modes}, got {given}{did_you_mean(given, COLLISION_MODES)}")


@dataclass(frozen=True, eq=False)
class ExportedObject:
    """An object to write: its shape, its joints, and the settings of the export.

    Attributes:
        shape: the shape.
        result: a prediction, or a bare mobility such as an annotation, in the frame and the length unit of the shape.
        options: the settings.
        notes: one line for everything that a user should know, such as what a format cannot carry. Writers add to it.
    """

    shape: Shape
    result: ShapeEstimate | Mobility
    options: ExportOptions
    notes: list[str] = field(default_factory=list)

    def note(self, line: str) -> None:
        """Add a note, unless it is there."""
        if line not in self.notes:
            self.notes.append(line)

    @property
    def mobility(self) -> Mobility:
        """The bodies and joints."""
        return self.result.mobility if isinstance(self.result, ShapeEstimate) else self.result

    @cached_property
    def robot(self) -> Robot:
        """The robot that simulators load. Its notes are added to those of the export."""
        options = self.options
        robot = build_robot(
            self.shape, self.mobility, options.metres_per_unit, collision=options.collision, physics=options.physics
        )
        for line in robot.notes:
            self.note(line)
        return robot


class Writer(Protocol):
    """A function that writes an object in one format into a folder that exists.

    It returns the path of the main file, or `folder` if the format has none.
    """

    def __call__(self, exported: ExportedObject, folder: Path, /) -> Path: ...
