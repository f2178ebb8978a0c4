"""The prepared shapes of a workspace by their use: training, validation, test, and pseudo-labelling."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
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
        copies: copies of labelled shapes that are not used: unlabelled ones, and labelled ones whose original is in another
            split.
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
    """Open the prepared shapes of a workspace.

    Args:
        workspace: the workspace.
        category: only shapes of this category, in any spelling; None for all.

    Returns:
        The shapes by their use, split by a hash of their ids (`kinmo.dataset.splits`).

    Raises:
        InputError: nothing was prepared, or nothing of the category.
    """
    store = PreparedStore(workspace.prepared, workspace.select)
    entries = [entry for entry in store.entries if category is None or same_category(entry.category, category)]
    if not entries:
        known = sorted({entry.category for entry in store.entries})
        if not known:
            raise InputError(workspace.prepared, "no prepared shapes: run kinmo prepare first")
        near = did_you_mean(category or "", known)
        raise InputError(workspace.prepared, f"no prepared shape of {category}{near}; there are {', '.join(known)}")
    is_oracle = {entry for entry in store.entries if _has_oracle_labels(entry)}
    labelled = [entry for entry in entries if entry.is_labelled]
    by_split, twice = _splits([entry for entry in labelled if entry not in is_oracle])
    unlabelled = [entry for entry in entries if not entry.is_labelled]
    is_copy = leaks(unlabelled, (entry for entry in store.entries if entry.is_labelled), {entry.id for entry in is_oracle})
    originals = tuple(entry for entry, copied in zip(unlabelled, is_copy, strict=True) if not copied)
    copies = tuple(entry for entry, copied in zip(unlabelled, is_copy, strict=True) if copied)
    oracle = tuple(entry for entry in labelled if entry in is_oracle)
    known_labels = (entry for entry in store.entries if entry.is_labelled and entry not in is_oracle)
    has_copy = leaks(oracle, (*known_labels, *originals), ())
    to_label = originals + tuple(entry for entry, copied in zip(oracle, has_copy, strict=True) if not copied)
    spelling = None if category is None else min(entry.category for entry in entries)
    return ShapeDataset(store, spelling, by_split, to_label, copies + twice, oracle, _oracle_ids(to_label, oracle))


def _has_oracle_labels(entry: IndexEntry) -> bool:
    """True for an oracle label that could be trained on; in the test split it is a test label like any other."""
    return entry.is_labelled and entry.is_oracle and split_of(entry.id) is not Split.TEST


def _splits(labelled: Iterable[IndexEntry]) -> tuple[dict[Split, tuple[IndexEntry, ...]], tuple[IndexEntry, ...]]:
    """The shapes of each split, and the shapes that are copies of a shape in another split, of which test comes first."""
    known = list(labelled)
    by_split: dict[Split, tuple[IndexEntry, ...]] = {}
    twice: list[IndexEntry] = []
    for split in (Split.TEST, Split.VALIDATION, Split.TRAIN):
        own = [entry for entry in known if split_of(entry.id) is split]
        before = [entry for entries in by_split.values() for entry in entries]
        is_copy = dict(zip(own, leaks(own, before, ()), strict=True))
        by_split[split] = tuple(entry for entry in own if not is_copy[entry])
        twice += (entry for entry in own if is_copy[entry])
    return by_split, tuple(twice)


def _oracle_ids(unlabelled: Iterable[IndexEntry], oracle: Iterable[IndexEntry]) -> dict[tuple[str, str], str]:
    """Ids of shapes with oracle labels, by id and layout of the shape and of its copies (recognised as in `leaks`)."""
    known = list(oracle)
    by_annotation = {entry.partnet_id: entry.id for entry in known if entry.partnet_id is not None}
    by_hash = {entry.geometry_hash: entry.id for entry in known}
    found = {(entry.id, entry.layout): entry.id for entry in known}
    for entry in unlabelled:
        original = by_annotation.get(entry.partnet_id or "") or by_hash.get(entry.geometry_hash)
        if original is not None:
            found[entry.id, entry.layout] = original
    return found
