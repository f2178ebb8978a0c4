"""Names for files, folders, links and joints."""

from __future__ import annotations

import re
import unicodedata
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


def identifier(text: str) -> str:
    """Letters, digits and `_` of a text, accents removed and other characters as `_`. Empty if no letter or digit is left.

    Example:
        >>> identifier("Tür links"), identifier("引き出し箱")
        ('Tur_links', '')
    """
    characters = (each for each in unicodedata.normalize("NFKD", text) if not unicodedata.category(each).startswith("M"))
    plain = "".join(each if each.isascii() else each.casefold() for each in characters)  # casefold writes ß as ss
    return re.sub(r"[^A-Za-z0-9_]+", "_", plain).strip("_")


def name_or_number(name: str, kind: str, number: int) -> str:
    """`name`, or the kind of a thing with its number if the name makes no identifier: "body_1".

    Args:
        name: The name of the thing in its source.
        kind: Word for things of its kind.
        number: Its number, by which people refer to it.
    """
    return name if identifier(name) else f"{kind}_{number}"


def unique_names(names: Iterable[str]) -> list[str]:
    """Convert names to identifiers (see `identifier`) that differ even if case is ignored, with no digit first.

    They are valid in URDF, MJCF and USD. A repeated name gets a number. One that begins with a digit, or has no valid
    character, begins with `part`.

    Example:
        >>> unique_names(["top door", "top/door", "3rd", ""])
        ['top_door', 'top_door_2', 'part_3rd', 'part']
    """
    taken: set[str] = set()
    result = []
    for name in names:
        stem = identifier(name)
        if not stem or stem[0].isdigit():
            stem = f"part_{stem}".strip("_")
        candidate, number = stem, 2
        while candidate.lower() in taken:
            candidate, number = f"{stem}_{number}", number + 1
        taken.add(candidate.lower())
        result.append(candidate)
    return result
