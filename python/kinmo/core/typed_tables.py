"""Typed tables: frozen dataclasses read from TOML or JSON with every type and bound checked, and written back."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import MISSING, asdict, dataclass, fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from kinmo.core.errors import InputError, did_you_mean

T = TypeVar("T")


@dataclass(frozen=True)
class Within:
    """Bounds of a number, or of the length of a list: `Annotated[int, Within(1, 9)]`."""

    low: float
    high: float = math.inf

    def __str__(self) -> str:
        if self.high < sys.float_info.max:
            return f"of {self.low:g} to {self.high:g}"
        return "above 0" if self.low == sys.float_info.min else f"of at least {self.low:g}"


def to_table(record: Any) -> dict[str, Any]:
    """A dataclass as nested dictionaries and lists for JSON, which `from_table` reads.

    Its fields hold numbers, texts, tuples, dictionaries and dataclasses.
    """

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(item) for key, item in value.items()}
        return [plain(item) for item in value] if isinstance(value, tuple) else value

    return {key: plain(value) for key, value in asdict(record).items()}


def from_table(kind: type[T], table: Mapping[str, Any], where: Path | str, prefix: str = "") -> T:
    """Build a dataclass from a table of TOML or JSON.

    Args:
        kind: the dataclass. Its type hints give the expected types and bounds.
        table: the values by field name.
        where: the file, for messages.
        prefix: the path of the table within the file, for messages.

    Raises:
        InputError: a key is unknown or missing, or a value has the wrong type or is out of bounds.
    """
    assert is_dataclass(kind)
    hints = get_type_hints(kind, include_extras=True)
    known = {f.name: f for f in fields(kind)}
    for key in table:
        if key not in known:
            raise InputError(where, f"unknown key{did_you_mean(key, known)}; expected one of {', '.join(known)}", prefix + key)
    values = {}
    for name, entry in known.items():
        if name in table:
            values[name] = _convert(hints[name], table[name], where, prefix + name)
        elif entry.default is MISSING and entry.default_factory is MISSING:
            raise InputError(where, "missing", prefix + name)
    return kind(**values)


def _convert(kind: Any, value: Any, where: Path | str, key: str) -> Any:
    origin = get_origin(kind)
    if origin is Annotated:
        kind, within = get_args(kind)
        converted = _convert(kind, value, where, key)
        size = len(converted) if isinstance(converted, tuple) else converted
        if not within.low <= size <= within.high:
            what = "a list with a length" if isinstance(converted, tuple) else "a number"
            raise InputError(where, f"expected {what} {within}, got {value!r}", key)
        return converted
    if is_dataclass(kind) and isinstance(kind, type):
        if not isinstance(value, Mapping):
            raise InputError(where, "expected a table", key)
        return from_table(kind, value, where, key + ".")
    if origin is Literal:
        if not isinstance(value, str) or value not in get_args(kind):
            raise InputError(where, f"expected one of {', '.join(get_args(kind))}, got {value!r}", key)
        return value
    if origin is tuple:
        if not isinstance(value, (list, tuple)):
            raise InputError(where, f"expected a list, got {value!r}", key)
        return tuple(_convert(get_args(kind)[0], item, where, f"{key}[{i}]") for i, item in enumerate(value))
    if origin in (Union, UnionType):
        (kind,) = (option for option in get_args(kind) if option is not type(None))
        return None if value is None else _convert(kind, value, where, key)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            raise InputError(where, "expected a number that is not that large", key) from None
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise InputError(where, f"expected {kind.__name__}, got {value!r}", key)
    return value
