"""TOML text from unknown sources."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_TOML_BYTES = 1 << 20
"""Largest file of settings or corrections."""
_MAX_DEPTH = 32
"""Deepest nesting of tables and lists."""
_KEY_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*"""
_DEEP_KEY = re.compile(rf"(?<![\w-])(?:{_KEY_PART}){{{_MAX_DEPTH}}}")
"""A key of too many parts. The parser would need a time that grows with the square of their number."""


def parse_toml(data: bytes, where: Path) -> dict[str, Any]:
    """The table of TOML in UTF-8. Raises InputError for anything else, for huge integers, and for deep nesting.

    Args:
        data: the text, of at most `MAX_TOML_BYTES`.
        where: the file, for messages.
    """
    if len(data) > MAX_TOML_BYTES:
        raise InputError(where, f"larger than {MAX_TOML_BYTES >> 20} MiB")
    try:
        text = data.decode("utf-8-sig")
        if _DEEP_KEY.search(text):
            raise RecursionError
        table: dict[str, Any] = tomllib.loads(text)
    except RecursionError:
        raise InputError(where, "expected TOML that is not nested so deeply") from None
    except ValueError as error:  # also for text that is not UTF-8, and for integers of thousands of digits
        raise InputError(where, f"expected TOML ({error})") from None
    level: list[Any] = [table]
    for _ in range(_MAX_DEPTH):
        inner = [list(value.values()) if isinstance(value, dict) else value for value in level]
        level = [item for items in inner for item in items if isinstance(item, dict | list)]
    if level:
        raise InputError(where, "expected TOML that is not nested so deeply")
    return table
