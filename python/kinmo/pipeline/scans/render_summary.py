"""What was scanned, as data and in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from kinmo.core.wording import counted
from kinmo.scans.scan_file import ScanFile

LINES = 8
"""Structures that are told one by one; all are in what --json prints."""


def summary(files: Sequence[ScanFile], unwanted: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """By category: objects and frames by role, structures, and frames refused by reason; and how many objects were not scanned
    by structure, of `unwanted` categories and structures.
    """
    found: dict[str, Any] = {}
    for category in sorted({*(file.category for file in files), *(name for name, _ in unwanted)}):
        own = [file for file in files if file.category == category]
        moving = [file for file in own if file.provenance.role != "unlabelled"]
        found[category] = {
            "objects": _objects_by((file.provenance.role, file) for file in own),
            "frames": sum(file.frames for file in own),
            "structures": _objects_by((str(file.structure), file) for file in moving),
            "not scanned": dict(Counter(structure for name, structure in unwanted if name == category).most_common()),
            "refused": dict(sum((Counter(file.refused) for file in own), Counter())),
        }
    return found


def _objects_by(files: Iterable[tuple[str, ScanFile]]) -> dict[str, int]:
    """How many objects there are scans of, by what stands before the files."""
    return dict(Counter(name for name, _ in {(name, file.object): None for name, file in files}))


def in_words(data: dict[str, Any]) -> str:
    """What `kinmo render` prints: of every category what `summary` has, and why objects are `refused`, by role and id."""
    lines = []
    for category, found in data["categories"].items():
        objects = ", ".join(f"{count} {role}" for role, count in found["objects"].items())
        reasons = ", ".join(f"{count} {reason}" for reason, count in found["refused"].items())
        refused = f"{sum(found['refused'].values())} refused" + (f" ({reasons})" if reasons else "")
        lines.append(f"{category}: {counted(found['frames'], 'frame')} of objects ({objects}); {refused}")
        lines += [*_structure_lines(found["structures"]), *_structure_lines(found["not scanned"], ", not scanned")]
    lines += [f"left out  {reason}" for by_id in data["refused"].values() for reason in by_id.values()]
    return "\n".join(lines)


def _structure_lines(counts: Mapping[str, int], ending: str = "") -> list[str]:
    """How many objects have each structure, the most common first, and the rare ones together."""
    ordered = sorted(counts.items(), key=lambda item: -item[1])
    lines = [f"    {count:5} {structure}{ending}" for structure, count in ordered[:LINES]]
    others = ordered[LINES:]
    if others:
        lines.append(f"    {sum(count for _, count in others):5} of {len(others)} more structures{ending}")
    return lines
