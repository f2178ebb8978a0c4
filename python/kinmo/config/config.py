"""Configuration of everything that kinmo trains, and its loading from TOML."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kinmo.config.motion import AxisConfig, GnnConfig, GroupingConfig, LimitsConfig, RankingConfig, RefinementConfig
from kinmo.config.scans import AncshConfig, ScansConfig
from kinmo.core.errors import InputError, did_you_mean
from kinmo.core.toml_text import MAX_TOML_BYTES, parse_toml
from kinmo.core.typed_tables import from_table

BUILTIN = Path(__file__).parent / "builtin"
"""Folder of the configurations that come with kinmo."""
EXTENDS = "extends"
"""Key of a file that extends a built-in configuration."""


@dataclass(frozen=True)
class Config:
    """All settings, by section."""

    gnn: GnnConfig
    """Motion GNN."""
    axis: AxisConfig
    """Axis-selection network."""
    grouping: GroupingConfig
    """Grouping networks."""
    ranking: RankingConfig
    """Ranking networks."""
    ancsh: AncshConfig
    """Networks for scans."""
    scans: ScansConfig = field(default_factory=ScansConfig)
    """Scanning."""
    limits: LimitsConfig = field(default_factory=LimitsConfig)
    """Limits network."""
    refinement: RefinementConfig = field(default_factory=RefinementConfig)
    """Refinement and acceptance of joints."""


def builtin_configs() -> tuple[str, ...]:
    """Names of the configurations that come with kinmo."""
    return tuple(sorted(path.stem for path in BUILTIN.glob("*.toml")))


def load_config(name: str | Path) -> Config:
    """Load a configuration from a TOML file, or one that comes with kinmo (`paper`, `small`) by name.

    A file that says `extends = "small"` need only say what is to differ from that.

    Raises:
        InputError: The file is absent or no TOML, a key is unknown or missing, or a value is of the wrong type.
    """
    path = BUILTIN / f"{name}.toml" if str(name) in builtin_configs() else Path(name)
    table, is_whole = _read_extended(path)
    try:
        return from_table(Config, table, path)
    except InputError as error:
        if not is_whole or error.problem != "missing":
            raise
        problem = f'missing; a file that is to say only what differs begins with {EXTENDS} = "small"'
        raise InputError(path, problem, error.field) from None


def _read_extended(path: Path) -> tuple[dict[str, Any], bool]:
    """The settings of a file with those that it extends, and whether the file is whole by itself."""
    table = _read_table(path)
    if EXTENDS not in table:
        return table, True
    extended = table.pop(EXTENDS)
    if extended not in builtin_configs():
        raise InputError(path, f"{extended!r}, expected one of {', '.join(builtin_configs())}", EXTENDS)
    below, _ = _read_extended(BUILTIN / f"{extended}.toml")
    return _merged(below, table), False


def _read_table(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            return parse_toml(file.read(MAX_TOML_BYTES + 1), path)
    except OSError as error:
        near, known = did_you_mean(str(path), builtin_configs()), ", ".join(builtin_configs())
        raise InputError(path, f"expected a TOML file or one of {known} ({error.strerror}){near}") from error


def _merged(table: Any, changes: Any) -> Any:
    """`table` with `changes`, key by key in tables of both."""
    if not (isinstance(table, dict) and isinstance(changes, dict)):
        return changes
    return table | {name: _merged(table.get(name), value) for name, value in changes.items()}
