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


def clean_text(text: str, most: int = MAX_TEXT_LENGTH) -> str:
    """`text` as one printable line of UTF-8, cut at `most` characters."""
    encodable = text[: 4 * most].encode("utf-8", "replace").decode("utf-8")
    return " ".join("".join(c if c.isprintable() else " " for c in encodable).split())[:most]


def shortened(text: str, most: int) -> str:
    """`text` as one printable line of at most `most` characters. A longer one loses its middle: the end has the remedy."""
    line = clean_text(text if len(text) <= 2 * most else text[:most] + text[-most:], 2 * most)
    if len(line) <= most and len(text) <= 2 * most:
        return line
    tail = most // 3
    return f"{line[: most - tail - 3]}...{line[-tail:]}"


def printable(text: str) -> str:
    """`text` with escapes for characters that cannot be printed."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def printable_path(path: Path | str) -> str:
    """A path as text that can be printed and stored. Bytes that are not UTF-8 are written as escapes."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")
