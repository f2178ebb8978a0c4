"""Words of the names of parts."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache


def words_of(name: str) -> list[str]:
    """The words of a name in lower case: runs of letters of any script."""
    return list(_words(name))


@lru_cache(maxsize=4096)
def _words(name: str) -> tuple[str, ...]:
    return tuple(re.findall(r"[^\W\d_]+", name.lower()))


def tell_apart(names: Iterable[str]) -> bool:
    """True if at least two names have different words. `Cube.001` and `Cube.002` have the same."""
    return len({_words(name) for name in names} - {()}) > 1
