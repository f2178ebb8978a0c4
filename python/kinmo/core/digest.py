"""Hashes of plain data."""

from __future__ import annotations

import json
from hashlib import blake2b


def digest(value: object) -> str:
    """A hash (32 hex digits) of plain data: the same for equal values, whatever the order of keys."""
    return blake2b(json.dumps(value, sort_keys=True, separators=(",", ":")).encode(), digest_size=16).hexdigest()
