"""Hashes of plain data, used as cache keys."""

from __future__ import annotations

import json
from hashlib import blake2b


def digest(value: object) -> str:
    """Hash of plain data, independent of the order of dictionary keys.

    Args:
        value: numbers, texts, lists and dictionaries, as JSON holds them.

    Returns:
        32 hexadecimal digits (BLAKE2b, 128 bits).
    """
    return blake2b(json.dumps(value, sort_keys=True, separators=(",", ":")).encode(), digest_size=16).hexdigest()
