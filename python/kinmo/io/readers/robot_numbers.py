"""Numbers in the attributes of robot files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from kinmo.core.errors import InputError
from kinmo.io.readers.robot_file import MAX_NUMBER, Matrix


def read_numbers(
    path: Path, attributes: Mapping[str, str], field: str, default: tuple[float, ...], largest: float = MAX_NUMBER
) -> Matrix:
    """The numbers of an attribute, as many as the default has. The default if there is no such attribute.

    Raises InputError for another number of numbers, and for those that are not finite or above `largest`.
    """
    if field not in attributes:
        return np.array(default)
    return read_list(path, attributes, field, len(default), len(default), largest)


def read_list(
    path: Path, attributes: Mapping[str, str], field: str, least: int, most: int, largest: float = MAX_NUMBER
) -> Matrix:
    """The numbers of an attribute, `least` to `most` of them (see `read_numbers`). Commas count as spaces."""
    text = attributes.get(field, "")
    try:
        values = np.array(text.replace(",", " ").split(), float)
    except ValueError:
        values = np.array([np.nan])
    if not least <= len(values) <= most or not np.all(np.abs(values) <= largest):
        count = str(least) if least == most else f"{least} to {most}"
        raise InputError(path, f"expected {count} finite numbers, of at most {largest:g}, found {text[:40]!r}", field)
    return values
