"""Notes about meshes that lie beside others, but that no file lists."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from kinmo.core.wording import clean_text

_MAX_NAMES = 20
"""Most files that a note names."""


def unlisted_meshes(folder: Path, listed: Collection[str], file: Path) -> list[str]:
    """A note about the OBJ files in a folder that `file` does not list. Empty if it lists all.

    Args:
        folder: the folder.
        listed: file names that are listed.
        file: the file that lists them.
    """
    try:
        found = sorted(entry.name for entry in os.scandir(folder) if entry.name.lower().endswith(".obj"))
    except OSError:
        return []
    names = [clean_text(name) for name in found if name not in listed]
    if not names:
        return []
    more = f" and {len(names) - _MAX_NAMES} more" if len(names) > _MAX_NAMES else ""
    return [f"{file.name} does not list {', '.join(names[:_MAX_NAMES])}{more} in {folder.name}: not read"]
