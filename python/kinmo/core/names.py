"""Names for files, folders, links and joints."""

from __future__ import annotations

import re
from collections.abc import Iterable
from urllib.parse import quote

from kinmo.core.digest import digest

MAX_NAME_BYTES = 150
"""Longest name on disk, in bytes of UTF-8. File systems allow 255: prefixes and endings need some of them."""


def name_on_disk(text: str) -> str:
    """Any text, such as the id of a shape, as a valid name for a file or folder. Different texts give different names."""
    return short_name(quote(text, safe=" "), text)


def short_name(name: str, text: str) -> str:
    """`name` if it has at most `MAX_NAME_BYTES`, else its beginning, `~`, and the hash of the full text it stands for."""
    encoded = name.encode()
    return name if len(encoded) <= MAX_NAME_BYTES else f"{encoded[:MAX_NAME_BYTES].decode(errors='ignore')}~{digest(text)}"


def unique_names(names: Iterable[str]) -> list[str]:
    """Convert names to identifiers that differ even if case is ignored: letters, digits and `_`, with no digit first.

    They are valid in URDF, MJCF and USD. A repeated name gets a number. One that begins with a digit, or has no valid
    character, begins with `part`.

    Example:
        >>> unique_names(["top door", "top/door", "3rd", ""])
        ['top_door', 'top_door_2', 'part_3rd', 'part']
    """
    taken: set[str] = set()
    result = []
    for name in names:
        stem = re.sub(r"[^A-Za-z0-9_]+", "_", name).strip("_")
        if not stem or stem[0].isdigit():
            stem = f"part_{stem}".strip("_")
        candidate, number = stem, 2
        while candidate.lower() in taken:
            candidate, number = f"{stem}_{number}", number + 1
        taken.add(candidate.lower())
        result.append(candidate)
    return result
