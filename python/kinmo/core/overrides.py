"""Overrides: what a person corrects in a prediction, body by body (docs/guide/correct.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from kinmo.core.errors import InputError
from kinmo.core.joint import KIND_WORDS
from kinmo.core.vector import Vector

FIXED = "fixed"
"""Type of a body that does not move against its parent."""
UNLIMITED = "unlimited"
"""Range of a joint without limits."""
KIND_OF_TYPE = {word: kind for kind, word in KIND_WORDS.items()}
"""Kinds of joints by the types that overrides name."""
TYPES = (*KIND_OF_TYPE, FIXED)

Reference = str | int
"""A body or part: its name, or its number (the `id` in joints.json)."""


@dataclass(frozen=True, eq=False)
class BodyOverride:
    """Correction of one body. A field that is None keeps what was predicted.

    Attributes:
        where: the file, for messages.
        path: the table in the file, such as "bodies.door", for messages.
        name: new name.
        type: hinge, slider, screw or fixed.
        axis: [3], unit vector along the axis.
        origin: [3], a point of the axis.
        range: smallest and largest value of the joint, in degrees (hinges) or lengths, or `UNLIMITED`. It contains 0, the pose
            of the file.
        parent: the body that this one is attached to.
        alternative: rank of the joint to use, among the estimates of the body; 1 is the best.
        parts: all parts of the body.
        flip: the joint opens the other way.
    """

    where: str
    path: str
    name: str | None = None
    type: str | None = None
    axis: Vector | None = None
    origin: Vector | None = None
    range: tuple[float, float] | str | None = None
    parent: Reference | None = None
    alternative: int | None = None
    parts: tuple[Reference, ...] | None = None
    flip: bool = False

    @property
    def joint_fields(self) -> dict[str, object]:
        """The fields that correct the joint, without those that keep what was predicted."""
        fields = {name: getattr(self, name) for name in ("type", "alternative", "axis", "origin", "range")}
        given: dict[str, object] = {name: value for name, value in fields.items() if value is not None}
        return {**given, "flip": True} if self.flip else given

    def fail(self, key: str, problem: str) -> InputError:
        """The error to raise about a field of this body."""
        return InputError(self.where, problem, f"{self.path}.{key}" if key else self.path)


@dataclass(frozen=True, eq=False)
class Overrides:
    """Corrections of one prediction, in the frame and the length unit of the shape.

    Attributes:
        bodies: corrections of predicted bodies, by the name or number that the file gives them.
        new_bodies: bodies that the prediction lacks, by their names.
        table: the content of the file as plain data, which JSON can hold.
    """

    bodies: Mapping[str, BodyOverride] = field(default_factory=dict)
    new_bodies: Mapping[str, BodyOverride] = field(default_factory=dict)
    table: Mapping[str, Any] = field(default_factory=dict)
