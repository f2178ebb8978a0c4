"""The scans of one category by their use: training, validation, test, and additional labels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.cache import Cache
from kinmo.dataset.shape_dataset import open_dataset
from kinmo.dataset.splits import Split, validation_from_training
from kinmo.dataset.store import PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import DSG_NET
from kinmo.methods import DEFAULT_METHOD
from kinmo.pipeline.scans.training_settings import Setting
from kinmo.scans.files.scan_file import ROLES, Role, ScanFile, open_scans
from kinmo.scans.object_structure import Structure

PAPER_CATEGORIES = ("Refrigerator", "Dishwasher", "Table", "Door", "Scissors")  # categories of the paper's Table 2
LABELLED: tuple[Role, ...] = tuple(split.value for split in Split)  # roles of labelled shapes
COMPLETE = "complete"  # name in a folder's cache that says that all scans of the folder were made
NO_FRAME, NO_SCAN = "no frame", "no scan"
"""Stand for the structure of objects without a usable frame, and of objects that cannot be scanned."""


def scans_folder(workspace: Workspace, category: str, role: Role, method: str = DEFAULT_METHOD) -> Path:
    """Folder of the scans of a category with a role; scans by pseudo labels have a folder for each method."""
    return workspace.scans / category / (f"pseudo-{method}" if role == "pseudo" else role)


@dataclass(frozen=True)
class ScanDataset:
    """The scans of a category's objects with one structure, by role. Scans of unlabelled objects have no structure.

    Attributes:
        others: Number of objects that are not used, by their structure (or `NO_FRAME`, `NO_SCAN`), role and layout.
        oracle_ids: Id of the shape with the oracle label, by id and layout (`ShapeDataset.oracle_ids`).
    """

    category: str
    structure: Structure
    files: Mapping[Role, tuple[ScanFile, ...]]
    others: Mapping[tuple[str, Role, str], int]
    oracle_ids: Mapping[tuple[str, str], str]

    def extra(self, setting: Setting) -> tuple[ScanFile, ...]:
        """Scans that a setting trains on besides those of the labelled shapes; those for self-training are not made yet."""
        if setting == "oracle":
            return self.files["oracle"]
        if setting == "semi-weakly":
            used = self._used_layouts()
            return tuple(file for file in self.files["pseudo"] if used(file.provenance.layout))
        return ()

    def count_other_structures(self) -> int:
        """Number of pseudo-labelled objects that could be trained on if they had this structure."""
        used = self._used_layouts()
        return sum(count for (_, role, layout), count in self.others.items() if role == "pseudo" and used(layout))

    def _used_layouts(self) -> Callable[[str], bool]:
        """Predicate of layouts: DSG-Net's generated shapes, which are coarser, are used only without other pseudo labels."""
        has_others = any(file.provenance.layout != DSG_NET for file in self.files["pseudo"])
        return lambda layout: not has_others or layout != DSG_NET


def scans_fingerprint(files: Sequence[ScanFile]) -> str:
    """Hash that changes when any of the scans would be made anew."""
    return digest([[file.id, file.provenance.key] for file in files])


def training_data(dataset: ScanDataset, extra: Sequence[ScanFile]) -> dict[str, str]:
    """Fingerprints of the scans that networks are trained and validated on."""
    training = (*dataset.files["train"], *extra)
    return {"training": scans_fingerprint(training), "validation": scans_fingerprint(dataset.files["validation"])}


def scanned_categories(workspace: Workspace) -> tuple[str, ...]:
    """Categories of prepared shapes that have scans; scans of shapes that are no longer prepared are ignored."""
    prepared = {entry.category for entry in PreparedStore(workspace.prepared, workspace.select).entries}
    scanned = sorted(path.name for path in workspace.scans.glob("*") if path.is_dir())
    return tuple(name for name in scanned if any(same_category(name, category) for category in prepared))


def open_scan_dataset(workspace: Workspace, category: str, method: str = DEFAULT_METHOD) -> ScanDataset:
    """Open the scans of a category in any spelling. A role whose scanning was interrupted has none.

    Scans of shapes that have become copies of a labelled shape, such as a new test shape, do not count.
    The structure is the most frequent one among the training objects (`usual_structure`). If no validation object has it, some
    training objects become validation objects; they are trained on too if there are no others.

    Raises:
        InputError: Nothing of the category was scanned, or the scanning of labelled shapes was interrupted.
    """
    known = scanned_categories(workspace)
    spelling = next((name for name in known if same_category(name, category)), None)
    if spelling is None:
        near, there = did_you_mean(category, known), f"; there are {', '.join(known)}" if known else ""
        raise InputError(workspace.scans, f"no scans of {category}{near}{there}: run kinmo render first")
    caches = {role: Cache(scans_folder(workspace, spelling, role, method)) for role in ROLES}
    done: list[Role] = [role for role in ROLES if COMPLETE in caches[role]]
    if not set(LABELLED) <= set(done):
        raise InputError(workspace.scans / spelling, "scanning was interrupted: run kinmo render again")
    paths = {role: sorted(caches[role].folder.glob("*.safetensors")) if role in done else [] for role in ROLES}
    dataset = open_dataset(workspace, spelling)
    copies = {(entry.id, entry.layout) for entry in dataset.copies}
    found = {role: [file for file in map(open_scans, paths[role]) if file.object not in copies] for role in ROLES}
    structure = usual_structure(found["train"])
    if structure is None:
        raise InputError(workspace.scans / spelling, _nothing_to_train_on(caches["train"]))
    fitting = {role: [file for file in found[role] if file.frames and file.structure == structure] for role in LABELLED}
    moved = frozenset[str]()
    if not fitting["validation"]:
        moved = validation_from_training({file.id for file in fitting["train"] if not file.provenance.variant})
        found["validation"] += [file for file in found["train"] if file.id in moved and not file.provenance.variant]
        if {file.id for file in fitting["train"]} <= moved:
            moved = frozenset()
    found["train"] = [file for file in found["train"] if file.id not in moved]
    for role in ("pseudo", "unlabelled"):  # copies of validation objects
        found[role] = [file for file in found[role] if dataset.oracle_ids.get(file.object) not in moved]
    files: dict[Role, tuple[ScanFile, ...]] = {}
    others: Counter[tuple[str, Role, str]] = Counter()
    for role, own in found.items():
        files[role] = tuple(f for f in own if f.frames > 0 and (role == "unlabelled" or f.structure == structure))
        used = {file.object for file in files[role]}
        rest = sorted((file for file in own if file.object not in used), key=lambda file: file.frames > 0)
        # an object counts once, by its structure if any frame shows it
        structures = {file.object: str(file.structure) if file.frames else NO_FRAME for file in rest}
        others.update((name, role, layout) for (_, layout), name in structures.items())
        others.update((name, role, layout) for name, layout in _skipped(caches[role]) if role in done)
    return ScanDataset(spelling, structure, files, others, dataset.oracle_ids)


def usual_structure(training: Sequence[ScanFile]) -> Structure | None:
    """Structure of most training objects; of equally frequent ones the one with fewer parts. None without any frame."""
    structures = Counter(structure for structure, _ in {(file.structure, file.object) for file in training if file.frames})
    return min(structures, key=lambda s: (-structures[s], s.part_count, str(s)), default=None)


def _skipped(cache: Cache) -> list[tuple[str, str]]:
    """Structure (or `NO_SCAN`) and layout of the objects of a folder that were not scanned; variants are left out."""
    known = (cache.data(name) or {} for name in cache)
    skipped = (data for data in known if "reason" in data and not data["variant"])
    return [(data["structure"] or NO_SCAN, data["layout"]) for data in skipped]


def _nothing_to_train_on(cache: Cache) -> str:
    """Message for a category without scans to train on: its objects may have other joints than the configuration names."""
    structures = Counter(name for name, _ in _skipped(cache) if name != NO_SCAN)
    names = ", ".join(name for name, _ in structures.most_common())
    hint = f"; the shapes have {names}, not the joints of scans.joints" if structures else ""
    return f"expected scans of a labelled shape to train on{hint}"
