"""overrides.toml: the corrections of one prediction, written by hand (docs/guide/correct.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.overrides import FIXED, TYPES, UNLIMITED, BodyOverride, Overrides, Reference
from kinmo.core.toml_text import MAX_TOML_BYTES, parse_toml
from kinmo.core.vector import Vector
from kinmo.io.readers.json_field import JsonField
from kinmo.io.readers.untrusted_files import read_bytes

OVERRIDES_FILE = "overrides.toml"
"""Name of the file beside joints.json."""
_TABLES = ("bodies", "new_bodies")
_URDF_TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slider", "helical": "screw"}
"""Words of URDF and of textbooks, and those that overrides use."""
_KEYS = ("name", "type", "axis", "origin", "range", "parent", "alternative", "parts", "flip")
_RANGE = f'two numbers, such as [0, 90], or "{UNLIMITED}"'
_NEW_KEYS = ("parts", "type", "axis", "origin", "range", "parent", "flip")


def read_overrides(path: Path) -> Overrides:
    """Read overrides.toml.

    Raises:
        InputError: the file is missing or no TOML, or a key or value is wrong. The message names file and field.
    """
    path = Path(path)
    return parse_overrides(parse_toml(read_bytes(path, path.parent, MAX_TOML_BYTES), path), path)


def parse_overrides(table: Mapping[str, Any], where: Path) -> Overrides:
    """Check the content of overrides.toml.

    Args:
        table: the tables `bodies` and `new_bodies`. NumPy arrays and tuples count as lists.
        where: the file, for messages.

    Raises:
        InputError: a key or value is wrong. The message names the field.
    """
    plain = _plain(table)
    root = JsonField(where, plain)
    for key in plain:
        if key not in _TABLES:
            hint = did_you_mean(key, _TABLES) or f": for a body of this name write [bodies.{key}]"
            raise InputError(where, f"unknown key{hint}", key)
    return Overrides(
        {key: _body(field, _KEYS, where) for key, field in _entries(root["bodies"]).items()},
        {key: _new_body(field, where) for key, field in _entries(root["new_bodies"]).items()},
        plain,
    )


def _entries(tables: JsonField) -> dict[str, JsonField]:
    if tables.is_absent:
        return {}
    if not isinstance(tables.value, dict):
        raise tables.fail(f"expected tables [{tables.path}.NAME]")
    return {key: tables[key] for key in tables.value}


def _new_body(field: JsonField, where: Path) -> BodyOverride:
    body = _body(field, _NEW_KEYS, where)
    for key in ("parts", "type"):
        if not getattr(body, key):
            raise body.fail(key, "needed for a new body")
    return body


def _body(field: JsonField, keys: Iterable[str], where: Path) -> BodyOverride:
    if not isinstance(field.value, dict):
        raise field.fail(f"expected a table [{field.path}]")
    for key in field.value:
        if key not in keys:
            if isinstance(field.value[key], dict):  # TOML takes a dot in a name for the start of a subtable
                table, name = field.path.split(".", 1)
                raise field[key].fail(f'unknown key: for a body called {name}.{key} write [{table}."{name}.{key}"]')
            raise field[key].fail(f"unknown key{did_you_mean(key, keys)}; expected one of {', '.join(keys)}")
    new_name, alternative = field["name"], field["alternative"]
    if not new_name.is_absent and not new_name.text():
        raise new_name.fail("expected a name")
    if not alternative.is_absent and alternative.integer() < 1:
        raise alternative.fail("expected the rank of a joint, 1 or more")
    return BodyOverride(
        where=str(where),
        path=field.path,
        name=None if new_name.is_absent else new_name.text(),
        type=_type(field["type"]),
        axis=_axis(field["axis"]),
        origin=None if field["origin"].is_absent else _numbers(field["origin"], 3, "three numbers, such as [0, 0.4, -0.2]"),
        range=_range(field["range"]),
        parent=None if field["parent"].is_absent else _reference(field["parent"], "body"),
        alternative=None if alternative.is_absent else alternative.integer(),
        parts=_parts(field["parts"]),
        flip=_flag(field["flip"]),
    )


def _type(field: JsonField) -> str | None:
    if field.is_absent:
        return None
    name = field.text()
    if name not in TYPES:
        near = f" (did you mean {_URDF_TYPES[name]}?)" if name in _URDF_TYPES else did_you_mean(name, TYPES)
        raise field.fail(f"expected one of {', '.join(TYPES)}, got {name}{near}")
    return name


def _axis(field: JsonField) -> Vector | None:
    if field.is_absent:
        return None
    vector = _numbers(field, 3, "three numbers, such as [0, 1, 0]")
    largest = float(np.max(np.abs(vector)))
    if largest == 0.0:
        raise field.fail("expected a direction, found zero")
    scaled = vector / largest
    return np.asarray(scaled / np.linalg.norm(scaled))


def _range(field: JsonField) -> tuple[float, float] | str | None:
    if field.is_absent:
        return None
    if isinstance(field.value, str):
        if field.value != UNLIMITED:
            raise field.fail(f"expected {_RANGE}")
        return UNLIMITED
    lower, upper = _numbers(field, 2, _RANGE).tolist()
    if lower > upper:
        raise field.fail(f"expected the smaller value first: [{upper:g}, {lower:g}]")
    if lower == upper:
        raise field.fail(f'expected two different values; for a body that does not move, write type = "{FIXED}"')
    if not lower <= 0.0 <= upper:
        raise field.fail("expected a range that contains 0, the pose in which the file shows the body")
    return lower, upper


def _numbers(field: JsonField, count: int, what: str) -> Vector:
    if not isinstance(field.value, list) or len(field.value) != count:
        raise field.fail(f"expected {what}")
    return field.vector(count)


def _parts(field: JsonField) -> tuple[Reference, ...] | None:
    if field.is_absent:
        return None
    if not isinstance(field.value, list):
        raise field.fail('expected a list of all parts, by name or by number, such as ["frame", 7]')
    return tuple(_reference(item, "part") for item in field.items())


def _reference(field: JsonField, what: str) -> Reference:
    if isinstance(field.value, int) and not isinstance(field.value, bool):
        return field.integer()
    if not isinstance(field.value, str):
        raise field.fail(f"expected the name or the number of a {what}")
    return field.text()


def _flag(field: JsonField) -> bool:
    if not isinstance(field.value, bool | None):
        raise field.fail("expected true or false")
    return bool(field.value)


def _plain(value: Any) -> Any:
    """Nested values as JSON and TOML can hold them. A key with the value None counts as absent."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value
