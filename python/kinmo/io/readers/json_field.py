"""JSON values that know their file and field, so that every error names both."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.core.vector import Vector
from kinmo.core.wording import clean_text

_MAX_INTEGER = 2**53
"""Largest integer that every JSON library keeps exactly."""


@dataclass(frozen=True)
class JsonField:
    """A JSON value with its place: the file `where` and the field `path`, such as `nodes[0].name`, empty for the whole file.

    An absent field has the value None, like null. The methods check the type of the value and raise InputError with file and
    field if it is wrong.
    """

    where: Path
    value: object
    path: str = ""

    def fail(self, problem: str) -> InputError:
        """The error to raise about this field."""
        return InputError(self.where, problem, self.path or None)

    @property
    def is_absent(self) -> bool:
        return self.value is None

    def __getitem__(self, key: str) -> JsonField:
        """The member `key` of an object. It is absent if the object has no such member."""
        if not isinstance(self.value, dict):
            raise self.fail("expected an object")
        return JsonField(self.where, self.value.get(key), f"{self.path}.{key}" if self.path else key)

    def items(self) -> list[JsonField]:
        """The items of a list. An absent field has none."""
        if self.value is None:
            return []
        if not isinstance(self.value, list):
            raise self.fail("expected a list")
        return [JsonField(self.where, item, f"{self.path}[{index}]") for index, item in enumerate(self.value)]

    def text(self, default: str | None = None) -> str:
        """A text, as one printable line."""
        if self.value is None and default is not None:
            return default
        if not isinstance(self.value, str):
            raise self.fail("expected a text")
        return clean_text(self.value)

    def whole_text(self) -> str:
        """A text as it is, of any length."""
        if not isinstance(self.value, str):
            raise self.fail("expected a text")
        return self.value

    def integer(self, default: int | None = None) -> int:
        if self.value is None and default is not None:
            return default
        if isinstance(self.value, bool) or not isinstance(self.value, int) or abs(self.value) > _MAX_INTEGER:
            raise self.fail("expected an integer" if not isinstance(self.value, int) else "integer out of range")
        return self.value

    def number(self, default: float | None = None) -> float:
        """A finite number."""
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
        """A truth value. False if the field is absent."""
        if not isinstance(self.value, int | None):
            raise self.fail("expected true or false")
        return bool(self.value)

    def vector(self, length: int = 3) -> Vector:
        """A list of `length` finite numbers, as float64 [length]."""
        numbers = self.items()
        if len(numbers) != length:
            raise self.fail(f"expected {length} numbers")
        return np.array([item.number() for item in numbers], np.float64)
