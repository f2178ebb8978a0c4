"""Summary of scans, as data and as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from kinmo.core.wording import counted
from kinmo.scans.files.scan_file import ScanFile

MAX_LINES = 8  # structures that are listed on the terminal; --json has all


def summarise(files: Sequence[ScanFile], unwanted: Sequence[tuple[str, str]]) -> dict[str, Any]:
    """Count objects and frames by category; `unwanted` has category and structure of each object of another structure."""
    found: dict[str, Any] = {}
    for category in sorted({*(file.category for file in files), *(name for name, _ in unwanted)}):
        own = [file for file in files if file.category == category]
        moving = [file for file in own if file.provenance.role != "unlabelled"]
        found[category] = {
            "objects": _count_objects((file.provenance.role, file) for file in own),
            "frames": sum(file.frames for file in own),
            "structures": _count_objects((str(file.structure), file) for file in moving),
            "not scanned": dict(Counter(structure for name, structure in unwanted if name == category).most_common()),
            "skipped frames": dict(sum((Counter(file.skipped) for file in own), Counter())),
        }
    return found


def _count_objects(files: Iterable[tuple[str, ScanFile]]) -> dict[str, int]:
    """Number of objects by the name that stands before each file."""
    return dict(Counter(name for name, _ in {(name, file.object): None for name, file in files}))


def summary_text(data: dict[str, Any]) -> str:
    """Text of `summarise`'s result (`data["categories"]`), and the reasons why objects were skipped (`data["skipped"]`)."""
    lines = []
    for category, found in data["categories"].items():
        objects = ", ".join(f"{count} {role}" for role, count in found["objects"].items())
        reasons = ", ".join(f"{count} {reason}" for reason, count in found["skipped frames"].items())
        skipped = f"{sum(found['skipped frames'].values())} frames skipped" + (f" ({reasons})" if reasons else "")
        lines.append(f"{category}: {counted(found['frames'], 'frame')} of objects ({objects}); {skipped}")
        lines += [*_structure_lines(found["structures"]), *_structure_lines(found["not scanned"], ", not scanned")]
    lines += [f"skipped: {reason}" for by_id in data["skipped"].values() for reason in by_id.values()]
    return "\n".join(lines)


def _structure_lines(counts: Mapping[str, int], ending: str = "") -> list[str]:
    """Objects by structure, the most frequent first, and the rare ones together."""
    ordered = Counter(counts).most_common()
    lines = [f"    {count:5} {structure}{ending}" for structure, count in ordered[:MAX_LINES]]
    if others := ordered[MAX_LINES:]:
        lines.append(f"    {sum(count for _, count in others):5} of {len(others)} more structures{ending}")
    return lines
