"""Which scans train, choose and test the networks of one category."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from kinmo.categories import same_category
from kinmo.errors import InputError, did_you_mean
from kinmo.pipeline.render import Labels
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import ScanFile, open_scans
from kinmo.workspace import Workspace, digest


@dataclass(frozen=True)
class ScanDataset:
    """The scans of a category's objects of one structure, by what they are for.

    `others` counts objects that were scanned but have another structure, by that and by what they are for: no network of
    this structure can say what they are.
    """

    category: str
    structure: Structure
    files: Mapping[Labels, tuple[ScanFile, ...]]
    others: Mapping[tuple[str, Labels], int]

    def fingerprint(self, files: Sequence[ScanFile]) -> str:
        """Changes whenever one of the files would be made anew."""
        return digest([[file.id, file.provenance["made_from"]] for file in files])


def scanned_categories(workspace: Workspace) -> tuple[str, ...]:
    """Categories of which there are scans."""
    return tuple(sorted(path.name for path in workspace.scans.glob("*") if path.is_dir()))


def open_scan_dataset(workspace: Workspace, category: str) -> ScanDataset:
    """The scans of a category, however it is spelled, of the structure that most objects to train on have.

    Where as many have another, that with fewer parts is taken. Raises InputError if nothing of it was scanned.
    """
    known = scanned_categories(workspace)
    spelling = next((name for name in known if same_category(name, category)), None)
    if spelling is None:
        near = did_you_mean(category, known)
        there = f"; there are {', '.join(known)}" if known else ""
        raise InputError(workspace.scans, f"no scans of {category}{near}{there}: run kinmo render first")
    files = [open_scans(path) for path in sorted((workspace.scans / spelling).rglob("*.safetensors"))]
    structures = Counter(file.structure for file in files if file.provenance["labels"] == "train" and file.frames)
    if not structures:
        raise InputError(workspace.scans / spelling, "expected scans of a labelled shape to train on")
    most = max(structures.values())
    structure = min((s for s, count in structures.items() if count == most), key=lambda s: (s.part_count, str(s)))
    own: dict[Labels, list[ScanFile]] = {"train": [], "validation": [], "test": [], "pseudo": []}
    others: Counter[tuple[str, Labels]] = Counter()
    for file in files:
        labels: Labels = file.provenance["labels"]
        if file.structure == structure and file.frames:
            own[labels].append(file)
        else:
            others[str(file.structure) if file.frames else "no frame", labels] += 1
    return ScanDataset(spelling, structure, {name: tuple(some) for name, some in own.items()}, others)
