"""Facts about a shape that the user states, because files do not have them or have them wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from kinmo.core.categories import canonical_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError
from kinmo.core.frames import AXIS_VECTORS, USUAL_FRONT, Axis
from kinmo.core.shape import Shape
from kinmo.io.readers.untrusted_files import MAX_SCENE_BYTES, read_bytes


@dataclass(frozen=True)
class StatedFacts:
    """Facts about a shape. Those that are None come from the file, or are guessed.

    Attributes:
        category: category of the object, in any spelling.
        up: axis of the file's frame that points up.
        front: axis of the file's frame that points to the viewer.
        metres_per_unit: length of a unit of the file, in metres.
        labels: an .npy file with one integer per triangle: the number of its part.
    """

    category: str | None = None
    up: Axis | None = None
    front: Axis | None = None
    metres_per_unit: float | None = None
    labels: Path | None = None

    def __post_init__(self) -> None:
        for name in ("up", "front"):
            if getattr(self, name) not in (None, *get_args(Axis)):
                raise InputError(name, f"expected one of {', '.join(get_args(Axis))}, got {getattr(self, name)}")
        if self.metres_per_unit is not None and not 0.0 < self.metres_per_unit < math.inf:
            raise InputError("metres_per_unit", f"expected a positive number, got {self.metres_per_unit}")

    def of(self, shape: Shape) -> Shape:
        """The shape with the stated facts. Labels are not applied, because a reader needs them.

        Raises:
            InputError: the front is not perpendicular to the up direction.
        """
        guesses = dict(shape.guesses)
        changes: dict[str, Any] = {}
        if self.category is not None:
            changes["category"] = canonical_category(self.category) if self.category else ""
            guesses.pop("category", None)
        if self.metres_per_unit is not None:
            changes["metres_per_unit"] = self.metres_per_unit
            guesses.pop("metres_per_unit", None)
        if self.up is not None:
            changes["up"] = AXIS_VECTORS[self.up]
            if not np.allclose(shape.up, changes["up"], atol=1e-9):  # else the format's own front still holds
                usual = USUAL_FRONT.get(self.up)
                changes["front"] = None if usual is None else AXIS_VECTORS[usual]
            guesses.pop("up", None)
        if self.front is not None:
            changes["front"] = AXIS_VECTORS[self.front]
            if abs(np.dot(changes.get("up", shape.up), changes["front"])) > 1e-6:
                remedy = "add --up" if self.up is None else "front and up must be perpendicular"
                raise InputError("--front", f"{self.front} is not perpendicular to the up direction: {remedy}")
        return replace(shape, guesses=guesses, **changes)

    def key(self) -> list[str | float | None]:
        """Plain data that changes with the facts, and with the content of the file of labels."""
        labels = None
        if self.labels is not None:
            labels = digest(read_bytes(self.labels, self.labels.parent, MAX_SCENE_BYTES).hex())
        return [self.category, self.up, self.front, self.metres_per_unit, labels]


NO_FACTS = StatedFacts()
