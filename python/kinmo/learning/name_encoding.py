"""Part names as hash buckets, so that known and unknown names alike have an encoding.

A name becomes its words and their character trigrams, and each of these is hashed into a bucket. A network encodes the name as
the mean of the buckets' embeddings. `drawer_box`, `drawer box` and `Drawers` therefore have similar encodings, and a word that
was never seen in training still has its trigrams.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

I64 = NDArray[np.int64]

HIDDEN = 0
"""Bucket of a hidden name, and of a name without letters."""


def name_buckets(name: str, buckets: int) -> list[int]:
    """Buckets (1..buckets-1) of the words and trigrams of a name, whatever its case, digits and punctuation."""
    words = re.findall(r"[^\W\d_]+", name.casefold())
    pieces = [w for word in words for w in (word, *(f"<{word}>"[i : i + 3] for i in range(len(word))))]
    return [1 + zlib.crc32(piece.encode()) % (buckets - 1) for piece in pieces] or [HIDDEN]


def encode_names(names: Sequence[str], buckets: int) -> tuple[I64, I64]:
    """The buckets of all N names, one name after the other [T], and the number of buckets of each name [N]."""
    encoded = [name_buckets(name, buckets) for name in names]
    return np.array([bucket for one in encoded for bucket in one], np.int64), np.array([len(one) for one in encoded], np.int64)
