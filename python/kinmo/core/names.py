"""Names for files, folders, links and joints."""

from __future__ import annotations

import re
from collections.abc import Iterable
from urllib.parse import quote

from kinmo.core.digest import digest

LONGEST_NAME = 150
"""Bytes of a name on disk: what comes before and after it has room in the 255 that there are."""


def name_on_disk(text: str) -> str:
    """A name for a file or folder, without ending, with nothing in it that a file system minds: another one for other text."""
    return short_name(quote(text, safe=" "), text)


def short_name(name: str, text: str) -> str:
    """`name`, for a file or folder, which stands for `text`: if it is too long it is cut, and told from others by a hash."""
    encoded = name.encode()
    return name if len(encoded) <= LONGEST_NAME else f"{encoded[:LONGEST_NAME].decode(errors='ignore')}~{digest(text)}"


def unique_names(names: Iterable[str], fallback: str = "part") -> list[str]:
    """Names of letters, digits, - and _ only, all different whatever their case; a repeated name gets a number."""
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
