"""JSON values that know the file and the field they come from, so that every complaint about them can name both."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.vector import Vector

_LARGEST_ID = 2**53
_LONGEST_TEXT = 200


def clean_text(text: str) -> str:
    """`text` as one printable line of UTF-8, cut at 200 characters."""
    encodable = text[: 4 * _LONGEST_TEXT].encode("utf-8", "replace").decode("utf-8")
    return " ".join("".join(c if c.isprintable() else " " for c in encodable).split())[:_LONGEST_TEXT]


@dataclass(frozen=True)
class Field:
    """A JSON value with its place: `where` is the file, `path` the field (empty for the whole file)."""

    where: Path
    value: object
    path: str = ""

    def fail(self, problem: str) -> InputError:
        """The error to raise about this field."""
        return InputError(self.where, problem, self.path or None)

    @property
    def is_absent(self) -> bool:
        return self.value is None

    def __getitem__(self, key: str) -> Field:
        """The member `key` of an object; an absent field (None) where there is no such member."""
        if not isinstance(self.value, dict):
            raise self.fail("expected an object")
        return Field(self.where, self.value.get(key), f"{self.path}.{key}" if self.path else key)

    def items(self) -> list[Field]:
        """The items of a list; none if the field is absent."""
        if self.value is None:
            return []
        if not isinstance(self.value, list):
            raise self.fail("expected a list")
        return [Field(self.where, item, f"{self.path}[{index}]") for index, item in enumerate(self.value)]

    def text(self, default: str | None = None) -> str:
        if self.value is None and default is not None:
            return default
        if not isinstance(self.value, str):
            raise self.fail("expected a text")
        return clean_text(self.value)

    def integer(self) -> int:
        if isinstance(self.value, bool) or not isinstance(self.value, int) or abs(self.value) > _LARGEST_ID:
            raise self.fail("expected an integer" if not isinstance(self.value, int) else "integer out of range")
        return self.value

    def number(self, default: float | None = None) -> float:
        if self.value is None and default is not None:
            return default
        if isinstance(self.value, bool) or not isinstance(self.value, (int, float)):
            raise self.fail("expected a number")
        try:
            number = float(self.value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fail("expected a finite number")
        return number

    def flag(self) -> bool:
        """A truth value; False if the field is absent."""
        if self.value is None:
            return False
        if not isinstance(self.value, (bool, int)):
            raise self.fail("expected true or false")
        return bool(self.value)

    def vector(self, length: int = 3) -> Vector:
        """A list of `length` finite numbers, as float64 [length]."""
        numbers = self.items()
        if len(numbers) != length:
            raise self.fail(f"expected {length} numbers")
        return np.array([item.number() for item in numbers], np.float64)
