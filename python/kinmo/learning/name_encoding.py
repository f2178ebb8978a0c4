"""Part names as sets of numbers that any name has, known or not.

A name becomes its words and their character trigrams, each hashed into a bucket; the mean of the buckets' embeddings stands for
the name. So `drawer_box`, `drawer box` and `Drawers` share most of what they are, and a word never seen still has its trigrams.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

HIDDEN = 0
"""Bucket of a name that is not shown."""


def name_buckets(name: str, buckets: int) -> list[int]:
    """Buckets of `name`, in 1..buckets-1; [HIDDEN] for a name without a letter."""
    words = re.findall(r"[^\W\d_]+", name.casefold())
    pieces = [w for word in words for w in (word, *(f"<{word}>"[i : i + 3] for i in range(len(word))))]
    return [1 + zlib.crc32(piece.encode()) % (buckets - 1) for piece in pieces] or [HIDDEN]


def bags(names: Sequence[str], buckets: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Buckets of all names one after the other [T], and how many each has [N]."""
    found = [name_buckets(name, buckets) for name in names]
    return np.array([b for bag in found for b in bag], np.int64), np.array([len(bag) for bag in found], np.int64)
