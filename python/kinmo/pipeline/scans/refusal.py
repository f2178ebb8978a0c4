"""What stands in place of the scans of an object that has none."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from kinmo.io.atomic_files import write_text_atomically

REFUSED = ".refused.json"
"""Ending of its name."""


@dataclass(frozen=True)
class Refusal:
    """Why an object was not scanned. If that is its `structure`, of which no network is trained, it is there; `made_from` is a
    hash of all else that the refusal depends on.
    """

    made_from: str
    reason: str
    structure: str | None = None


def refusal_path(scans: Path) -> Path:
    """Where the refusal is of what `scans` would be of."""
    return scans.with_suffix(REFUSED)


def write_refusal(path: Path, refusal: Refusal) -> None:
    """Write it, whole or not at all."""
    write_text_atomically(path, json.dumps(asdict(refusal), ensure_ascii=False) + "\n")


def read_refusal(path: Path) -> Refusal | None:
    """The refusal; None where there is none, or none that can be read."""
    try:
        return Refusal(**json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None
