"""Hashes of plain data, used as cache keys."""

from __future__ import annotations

import json
from hashlib import blake2b


def digest(value: object) -> str:
    """Hash of data that JSON can hold (32 hexadecimal digits), independent of the order of dictionary keys."""
    return blake2b(json.dumps(value, sort_keys=True, separators=(",", ":")).encode(), digest_size=16).hexdigest()
