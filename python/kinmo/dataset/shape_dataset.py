"""Which prepared shapes train, choose, test, and get pseudo labels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from kinmo.core.categories import same_category
from kinmo.core.digest import digest
from kinmo.core.errors import InputError, did_you_mean
from kinmo.dataset.splits import Split, leaks, split_of, within_share
from kinmo.dataset.store import IndexEntry, PreparedStore, made_from
from kinmo.dataset.workspace import Workspace
from kinmo.features.prepared_shape import PreparedShape


@dataclass(frozen=True)
class Dataset:
    """The prepared shapes of a workspace by their use. `copies` of labelled ones are left alone: those without labels, and
    those that have them too where one of both is for tests or to choose by.

    `category` is what all of them are, as the index spells it, or None. `hidden` are shapes that could be trained on, had their
    labels not been held back, or left out by the workspace's share of labels. They are `unlabelled` too, unless they have an
    unlabelled copy, which then is. `truths` tells for shapes (id and layout) that are hidden ones, or copies of such, the id of
    the hidden one.
    """

    store: PreparedStore
    category: str | None
    labelled: Mapping[Split, tuple[IndexEntry, ...]]
    unlabelled: tuple[IndexEntry, ...]
    copies: tuple[IndexEntry, ...]
    hidden: tuple[IndexEntry, ...] = ()
    truths: Mapping[tuple[str, str], str] = field(default_factory=dict)

    def load(self, entries: Iterable[IndexEntry]) -> list[PreparedShape]:
        return [self.store.load(entry) for entry in entries]

    def fingerprint(self, entries: Iterable[IndexEntry]) -> str:
        """Changes whenever the files or the preparation of one of the shapes do."""
        return digest([made_from(self.store.folder / entry.file) for entry in entries])

    def categories(self) -> tuple[str, ...]:
        """Categories of the labelled shapes."""
        return tuple(sorted({entry.category for entries in self.labelled.values() for entry in entries}))


def open_dataset(workspace: Workspace, category: str | None = None) -> Dataset:
    """The dataset of a workspace, or its shapes of one category whatever the spelling.

    Splits are `kinmo.dataset.splits`'. Raises InputError if nothing was prepared, or nothing of that category.
    """
    store = PreparedStore(workspace.prepared)
    entries = [entry for entry in store.entries if category is None or same_category(entry.category, category)]
    if not entries:
        known = sorted({entry.category for entry in store.entries})
        if not known:
            raise InputError(workspace.prepared, "no prepared shapes: run kinmo prepare first")
        near = did_you_mean(category or "", known)
        raise InputError(workspace.prepared, f"no prepared shape of {category}{near}; there are {', '.join(known)}")
    labelled = [entry for entry in entries if entry.is_labelled]
    hidden = _hidden(store.entries, workspace.labels)
    by_split, twice = _splits([entry for entry in labelled if entry not in hidden])
    unlabelled = [entry for entry in entries if not entry.is_labelled]
    names = {entry.id for entry in hidden}
    is_copy = leaks(unlabelled, (entry for entry in store.entries if entry.is_labelled), names)
    originals, copies = (
        tuple(entry for entry, leaking in zip(unlabelled, is_copy, strict=True) if leaking is wanted)
        for wanted in (False, True)
    )
    own_hidden = tuple(entry for entry in labelled if entry in hidden)
    counted = (*(entry for entry in store.entries if entry.is_labelled and entry not in hidden), *originals)
    alone = tuple(entry for entry, copied in zip(own_hidden, leaks(own_hidden, counted, ()), strict=True) if not copied)
    spelling = None if category is None else min(entry.category for entry in entries)
    unlabelled_ones = originals + alone
    truths = _truths(unlabelled_ones, own_hidden)
    return Dataset(store, spelling, by_split, unlabelled_ones, copies + twice, own_hidden, truths)


def _splits(labelled: Iterable[IndexEntry]) -> tuple[dict[Split, tuple[IndexEntry, ...]], tuple[IndexEntry, ...]]:
    """The shapes of each split; and what else would be in one of them, but has a copy in another, that comes before it."""
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


def _hidden(entries: Iterable[IndexEntry], share: float) -> frozenset[IndexEntry]:
    """Labelled shapes that are not for tests and whose labels nothing may be learnt from: those that are held back, and all but
    a `share` of those to train on, of each category.
    """
    labelled = [entry for entry in entries if entry.is_labelled]
    hidden = {entry for entry in labelled if entry.is_held_back and split_of(entry.id) is not Split.TEST}
    training = [entry for entry in labelled if entry not in hidden and split_of(entry.id) is Split.TRAIN]
    kept = within_share(((entry.id, entry.category) for entry in training), share)
    return frozenset(hidden | {entry for entry, keep in zip(training, kept, strict=True) if not keep})


def _truths(unlabelled: Iterable[IndexEntry], hidden: Iterable[IndexEntry]) -> dict[tuple[str, str], str]:
    """What tells copies is what `leaks` goes by."""
    known = list(hidden)
    by_annotation = {entry.partnet_id: entry.id for entry in known if entry.partnet_id is not None}
    by_hash = {entry.geometry_hash: entry.id for entry in known}
    found = {(entry.id, entry.layout): entry.id for entry in known}
    for entry in unlabelled:
        truth = by_annotation.get(entry.partnet_id or "") or by_hash.get(entry.geometry_hash)
        if truth is not None:
            found[entry.id, entry.layout] = truth
    return found
