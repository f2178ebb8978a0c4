"""Text for messages and captions."""

from __future__ import annotations

import os
from pathlib import Path

MAX_TEXT_LENGTH = 200
"""Longest text that `clean_text` returns, in characters."""


def counted(count: int, noun: str) -> str:
    """A number with its noun, in the plural where needed: `1 object`, `2 objects`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def duration(seconds: float) -> str:
    """A duration in seconds, minutes or hours: `45 s`, `12 min`, `1.5 h`."""
    if seconds < 90:
        return f"{max(round(seconds), 1)} s"
    return f"{round(seconds / 60)} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def clean_text(text: str) -> str:
    """`text` as one printable line of UTF-8, cut at `MAX_TEXT_LENGTH` characters."""
    encodable = text[: 4 * MAX_TEXT_LENGTH].encode("utf-8", "replace").decode("utf-8")
    return " ".join("".join(c if c.isprintable() else " " for c in encodable).split())[:MAX_TEXT_LENGTH]


def printable_path(path: Path | str) -> str:
    """A path as text that can be printed and stored. Bytes that are not UTF-8 are written as escapes."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")
