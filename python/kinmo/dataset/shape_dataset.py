"""The prepared shapes of a workspace by their use: training, validation, test, and pseudo-labelling."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.splits import Split, leaks, split_of
from kinmo.dataset.store import IndexEntry, PreparedStore
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape


@dataclass(frozen=True)
class ShapeDataset:
    """The prepared shapes of a workspace by their use.

    Attributes:
        store: where the prepared shapes are read from.
        category: the category of all shapes, spelled as in the index; None if there are several.
        labelled: labelled shapes by split.
        unlabelled: shapes to pseudo-label: those without labels, and those with oracle labels, unless such a shape has an
            unlabelled copy, which then stands for it.
        copies: copies of labelled shapes that are not used: unlabelled ones, labelled ones whose original is in another
            split, and shapes with oracle labels whose original is a validation or test shape.
        oracle: shapes with oracle labels that could be trained on.
        oracle_ids: id of the shape with the oracle label, by id and layout, for that shape and its copies.
    """

    store: PreparedStore
    category: str | None
    labelled: Mapping[Split, tuple[IndexEntry, ...]]
    unlabelled: tuple[IndexEntry, ...]
    copies: tuple[IndexEntry, ...]
    oracle: tuple[IndexEntry, ...] = ()
    oracle_ids: Mapping[tuple[str, str], str] = field(default_factory=dict)

    def load(self, entries: Iterable[IndexEntry]) -> list[PreparedShape]:
        """Read the prepared shapes of some entries."""
        return [self.store.load(entry) for entry in entries]

    def categories(self) -> tuple[str, ...]:
        """Categories of the labelled shapes, sorted."""
        return tuple(sorted({entry.category for entries in self.labelled.values() for entry in entries}))


def fingerprint(entries: Iterable[IndexEntry]) -> str:
    """Hash that changes with the files or the preparation of any of the shapes."""
    return digest([entry.key for entry in entries])


def open_dataset(workspace: Workspace, category: str | None = None) -> ShapeDataset:
    """The prepared shapes of a workspace by their use, split by a hash of their ids (`kinmo.dataset.splits`).

    With a category, in any spelling, only its shapes are included. Raises InputError if there are none.
    """
    store = PreparedStore(workspace.prepared, workspace.select)
    entries = [entry for entry in store.entries if category is None or same_category(entry.category, category)]
    if not entries:
        categories = sorted({entry.category for entry in store.entries})
        if not categories:
            raise InputError(workspace.prepared, "no prepared shapes: run kinmo prepare first")
        near = did_you_mean(category or "", categories)
        raise InputError(workspace.prepared, f"no prepared shape of {category}{near}; there are {', '.join(categories)}")
    is_oracle = {entry for entry in store.entries if _has_oracle_labels(entry)}
    labelled = [entry for entry in entries if entry.is_labelled]
    by_split, twice = _splits([entry for entry in labelled if entry not in is_oracle])
    unlabelled = [entry for entry in entries if not entry.is_labelled]
    all_labelled = [entry for entry in store.entries if entry.is_labelled]
    originals, copies = _without_copies(unlabelled, all_labelled, {entry.id for entry in is_oracle})
    known = [entry for entry in all_labelled if entry not in is_oracle]
    held_out = [entry for entry in known if split_of(entry.id) is not Split.TRAIN]
    oracle, seen = _without_copies([entry for entry in labelled if entry in is_oracle], held_out)
    to_label = originals + _without_copies(oracle, (*known, *originals))[0]
    spelling = None if category is None else min(entry.category for entry in entries)
    return ShapeDataset(store, spelling, by_split, to_label, copies + twice + seen, oracle, _oracle_ids(to_label, oracle))


def _has_oracle_labels(entry: IndexEntry) -> bool:
    """True for an oracle label that could be trained on; in the test split it is a test label like any other."""
    return entry.is_labelled and entry.is_oracle and split_of(entry.id) is not Split.TEST


def _without_copies(
    entries: Sequence[IndexEntry], others: Iterable[IndexEntry], oracle: Collection[str] = ()
) -> tuple[tuple[IndexEntry, ...], tuple[IndexEntry, ...]]:
    """The entries that are no copies of `others` (see `leaks`), and those that are."""
    is_copy = leaks(entries, others, oracle)
    kept, copies = (
        tuple(entry for entry, copied in zip(entries, is_copy, strict=True) if copied is wanted) for wanted in (False, True)
    )
    return kept, copies


def _splits(labelled: Sequence[IndexEntry]) -> tuple[dict[Split, tuple[IndexEntry, ...]], tuple[IndexEntry, ...]]:
    """The shapes of each split, and the shapes that are copies of a shape in another split, of which test comes first."""
    by_split: dict[Split, tuple[IndexEntry, ...]] = {}
    twice: tuple[IndexEntry, ...] = ()
    for split in (Split.TEST, Split.VALIDATION, Split.TRAIN):
        own = [entry for entry in labelled if split_of(entry.id) is split]
        by_split[split], copies = _without_copies(own, [entry for entries in by_split.values() for entry in entries])
        twice += copies
    return by_split, twice


def _oracle_ids(unlabelled: Iterable[IndexEntry], oracle: Sequence[IndexEntry]) -> dict[tuple[str, str], str]:
    """Ids of shapes with oracle labels, by id and layout of the shape and of its copies (recognised as in `leaks`)."""
    by_annotation = {entry.partnet_id: entry.id for entry in oracle if entry.partnet_id is not None}
    by_hash = {entry.geometry_hash: entry.id for entry in oracle}
    found = {(entry.id, entry.layout): entry.id for entry in oracle}
    for entry in unlabelled:
        original = by_annotation.get(entry.partnet_id or "") or by_hash.get(entry.geometry_hash)
        if original is not None:
            found[entry.id, entry.layout] = original
    return found
