"""How messages, plans and captions put things."""

from __future__ import annotations


def counted(count: int, noun: str) -> str:
    """So many of something that takes an s: `1 object`, `2 objects`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
