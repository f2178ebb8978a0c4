"""Names for files, folders, links and joints."""

from __future__ import annotations

import re
from collections.abc import Iterable
from urllib.parse import quote

from kinmo.core.digest import digest

MAX_NAME_BYTES = 150
"""Longest name on disk, in bytes of UTF-8. File systems allow 255: prefixes and endings need some of them."""


def name_on_disk(text: str) -> str:
    """A valid name for a file or folder, without ending. Different texts give different names.

    Args:
        text: any text, such as the id of a shape.

    Returns:
        The text, percent-encoded and cut to `MAX_NAME_BYTES`.
    """
    return short_name(quote(text, safe=" "), text)


def short_name(name: str, text: str) -> str:
    """Shorten a name for a file or folder to `MAX_NAME_BYTES`.

    Args:
        name: the name.
        text: the full text that the name stands for. Its hash keeps shortened names apart.

    Returns:
        `name` if it is short enough, else its beginning followed by `~` and the hash.
    """
    encoded = name.encode()
    return name if len(encoded) <= MAX_NAME_BYTES else f"{encoded[:MAX_NAME_BYTES].decode(errors='ignore')}~{digest(text)}"


def unique_names(names: Iterable[str], fallback: str = "part") -> list[str]:
    """Convert names to unique identifiers of letters, digits, `-` and `_`.

    Args:
        names: any texts.
        fallback: the name for texts without a valid character.

    Returns:
        One name for each text, all different even if case is ignored. A repeated name gets a number.

    Example:
        >>> unique_names(["top door", "top/door", ""])
        ['top_door', 'top_door_2', 'part']
    """
    taken: set[str] = set()
    result = []
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or fallback
        candidate, number = stem, 2
        while candidate.lower() in taken:
            candidate, number = f"{stem}_{number}", number + 1
        taken.add(candidate.lower())
        result.append(candidate)
    return result
