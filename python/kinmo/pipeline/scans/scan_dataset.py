"""Which scans train, choose and test the networks of one category."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split, kept_to_choose_by
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import Layout
from kinmo.pipeline.scans.refusal import REFUSED, read_refusal
from kinmo.pipeline.scans.training_settings import PSEUDO_LABELLED, Setting, is_pseudo_labelled_for
from kinmo.scans.articulated_object import Structure
from kinmo.scans.scan_file import ROLES, Role, ScanFile, open_scans

PAPER_CATEGORIES = ("Refrigerator", "Dishwasher", "Table", "Door", "Scissors")
"""Of the paper's Table 2."""

LABELLED: tuple[Role, ...] = tuple(split.value for split in Split)
"""Roles of labelled shapes."""
NO_FRAME, NO_SCAN = "no frame", "no scan"
"""Stand for the structure of objects that were scanned, but too little of some part was seen in every frame; and of those that
cannot be scanned."""


def scans_of(workspace: Workspace, category: str, role: Role) -> Path:
    """The folder of the scans with a role."""
    places = {"pseudo": workspace.own_scans, "unlabelled": workspace.without_pseudo_labels.own_scans}
    return places.get(role, workspace.scans) / category / role


def unfinished(workspace: Workspace, category: str, role: Role) -> Path:
    """The file that is there while scans with a role are made, and stays where that was stopped."""
    return scans_of(workspace, category, role) / "unfinished"


@dataclass(frozen=True)
class ScanDataset:
    """The scans of a category's objects of one structure, by role; those of `unlabelled` objects have no structure.

    `others` counts objects that have another structure, by that, by role and by the layout they came in: no network of this
    structure can say what they are. `truths` are as in `Dataset`.
    """

    category: str
    structure: Structure
    files: Mapping[Role, tuple[ScanFile, ...]]
    others: Mapping[tuple[str, Role, str], int]
    truths: Mapping[tuple[str, str], str]

    def beside(self, setting: Setting) -> tuple[ScanFile, ...]:
        """What to train on in a setting beside the labelled shapes; what networks label for `semi` is not among them."""
        if setting == "ceiling":
            return self.files["hidden"]
        if setting in PSEUDO_LABELLED:
            return tuple(file for file in self.files["pseudo"] if is_pseudo_labelled_for(setting, file.provenance.layout))
        return ()

    def left_out(self, setting: Setting) -> int:
        """How many objects with pseudo labels a setting could have been trained on, had they this structure."""
        counts = ((layout, count) for (_, role, layout), count in self.others.items() if role == "pseudo")
        return sum(count for layout, count in counts if is_pseudo_labelled_for(setting, layout))


def fingerprint(files: Sequence[ScanFile]) -> str:
    """Changes whenever one of the files would be made anew."""
    return digest([[file.id, file.provenance.made_from] for file in files])


def training_data(dataset: ScanDataset, beside: Sequence[ScanFile]) -> dict[str, str]:
    """What networks that are trained on the labelled objects, and on those `beside` them, are made from."""
    training = (*dataset.files["train"], *beside)
    return {"training": fingerprint(training), "validation": fingerprint(dataset.files["validation"])}


def scanned_categories(workspace: Workspace) -> tuple[str, ...]:
    """Categories of prepared shapes of which there are scans. Scans of what was prepared before stay where they are."""
    prepared = {entry.category for entry in PreparedStore(workspace.prepared).entries}
    scanned = sorted(path.name for path in workspace.scans.glob("*") if path.is_dir())
    return tuple(name for name in scanned if any(same_category(name, category) for category in prepared))


def open_scan_dataset(workspace: Workspace, category: str) -> ScanDataset:
    """The scans of a category, however it is spelled, of the structure that most objects to train on have (`usual_structure`).

    What is trained on and what is hidden is as the workspace's share of labels has it; the structure does not depend on that,
    nor do validation shapes. If none of these has the structure, some of all labelled ones take their place, and are trained on
    too only where nothing else is left. Raises InputError if nothing of it was scanned, or not all labelled shapes; of other
    roles, as long as not all is scanned, there is nothing.
    """
    known = scanned_categories(workspace)
    spelling = next((name for name in known if same_category(name, category)), None)
    if spelling is None:
        near = did_you_mean(category, known)
        there = f"; there are {', '.join(known)}" if known else ""
        raise InputError(workspace.scans, f"no scans of {category}{near}{there}: run kinmo render first")
    done: list[Role] = [role for role in ROLES if not unfinished(workspace, spelling, role).exists()]
    if not set(LABELLED) <= set(done):
        raise InputError(workspace.scans / spelling, "scanning was stopped before all was done: run kinmo render again")
    found = {role: _open_all(scans_of(workspace, spelling, role)) if role in done else [] for role in ROLES}
    structure = usual_structure(found["train"])
    if structure is None:
        raise InputError(workspace.scans / spelling, _without_any(scans_of(workspace, spelling, "train")))
    dataset = open_dataset(workspace, spelling)
    counted = {entry.id for entry in dataset.labelled[Split.TRAIN]}
    fitting = {role: [file for file in found[role] if file.frames and file.structure == structure] for role in ROLES}
    kept = frozenset[str]()
    if not fitting["validation"]:
        ids = {file.id for file in fitting["train"]}
        kept = kept_to_choose_by({file.id for file in fitting["train"] if not file.provenance.variant})
        found["validation"] += [file for file in found["train"] if file.id in kept and not file.provenance.variant]
        kept = kept if ids & (counted - kept) else kept - counted
    labelled = [file for file in found["train"] if file.id not in kept]
    found["hidden"] += [file for file in labelled if file.id not in counted]
    found["train"] = [file for file in labelled if file.id in counted]
    for role in ("pseudo", "unlabelled"):  # copies of what is chosen by
        found[role] = [file for file in found[role] if dataset.truths.get(file.object) not in kept]
    files: dict[Role, tuple[ScanFile, ...]] = {}
    others: Counter[tuple[str, Role, str]] = Counter()
    for role, some in found.items():
        files[role] = tuple(f for f in some if f.frames > 0 and (role == "unlabelled" or f.structure == structure))
        kept_objects = {file.object for file in files[role]}
        rest = (file for file in some if file.object not in kept_objects)
        left_out: dict[tuple[object, str], str] = {}  # an object is left out once, by its structure if any frame shows it
        for f in sorted(rest, key=lambda f: f.frames > 0):
            left_out[f.object, f.provenance.layout] = str(f.structure) if f.frames else NO_FRAME
        others.update((reason, role, layout) for (_, layout), reason in left_out.items())
        for layout in (each.value for each in Layout if role in done):
            for path in scans_of(workspace, spelling, role).glob(f"*-{layout}{REFUSED}"):  # names of variants end otherwise
                refusal = read_refusal(path)
                others[(refusal.structure if refusal else None) or NO_SCAN, role, layout] += 1
    return ScanDataset(spelling, structure, files, others, dataset.truths)


def usual_structure(training: Sequence[ScanFile]) -> Structure | None:
    """The structure that most objects have that scans to train on are of; where as many have another, that with fewer parts.

    None if there is no frame of any.
    """
    structures = Counter(structure for structure, _ in {(file.structure, file.object) for file in training if file.frames})
    if not structures:
        return None
    most = max(structures.values())
    return min((s for s, count in structures.items() if count == most), key=lambda s: (s.part_count, str(s)))


def _without_any(folder: Path) -> str:
    """What is wrong with a folder of no scans to train on: maybe objects there have all other joints than those asked for."""
    refusals = (read_refusal(path) for path in sorted(folder.glob(f"*{REFUSED}")))
    structures = Counter(refusal.structure for refusal in refusals if refusal is not None and refusal.structure)
    told = "expected scans of a labelled shape to train on"
    if structures:
        told += (
            f"; those there are have {', '.join(name for name, _ in structures.most_common())}, not the joints of scans.joints"
        )
    return told


def _open_all(folder: Path) -> list[ScanFile]:
    return [open_scans(path) for path in sorted(folder.glob("*.safetensors"))]
