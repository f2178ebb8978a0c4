"""Loading of configurations from TOML."""

from __future__ import annotations

import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

from kinmo.config.config import Config
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.typed_tables import from_table

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

EXTENDS = "extends"
"""Key of a file that extends a built-in configuration."""


def load_config(name: str | Path) -> Config:
    """The configuration in a TOML file, or one of those that come with kinmo (`paper`, `small`) by name.

    A file that says `extends = "small"` need only say what is to differ from that.

    Raises InputError for a file that is absent or no TOML, an unknown or missing key, or a value of the wrong type.
    """
    path = _builtin_path(str(name)) if str(name) in builtin_configs() else Path(name)
    table = _read_table(path)
    is_whole = EXTENDS not in table
    if not is_whole:
        extended = table.pop(EXTENDS)
        if extended not in builtin_configs():
            raise InputError(path, f"{extended!r}, expected one of {', '.join(builtin_configs())}", EXTENDS)
        table = _merged(_read_table(_builtin_path(extended)), table)
    try:
        return from_table(Config, table, path)
    except InputError as error:
        if not is_whole or error.problem != "missing":
            raise
        problem = f'missing; a file that is to say only what differs begins with {EXTENDS} = "small"'
        raise InputError(path, problem, error.field) from None


def _builtin_path(name: str) -> Path:
    return Path(str(files("kinmo.config") / "builtin" / f"{name}.toml"))


def _read_table(path: Path) -> dict[str, Any]:
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        near, known = did_you_mean(str(path), builtin_configs()), ", ".join(builtin_configs())
        raise InputError(path, f"expected a TOML file or one of {known} ({error.strerror}){near}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(path, f"expected TOML ({error})") from error
    return table


def _merged(table: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """`table` with `changes`, key by key in tables of both."""
    both = {name: _merged(table[name], value) for name, value in changes.items() if _is_table(value, table.get(name))}
    return table | changes | both


def _is_table(*values: object) -> bool:
    return all(isinstance(value, dict) for value in values)


def builtin_configs() -> tuple[str, ...]:
    """Names of the configurations that come with kinmo."""
    return tuple(sorted(Path(str(f)).stem for f in (files("kinmo.config") / "builtin").iterdir() if f.name.endswith(".toml")))
