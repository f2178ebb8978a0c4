"""Workspaces derived from another one: with fewer labels, with other unlabelled shapes, or with scans of a noisy sensor."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from hashlib import blake2b

from kinmo.dataset.splits import Split, split_of
from kinmo.dataset.store import IndexEntry, PreparedStore, write_index
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import DSG_NET


@dataclass(frozen=True)
class Variant:
    """Change that makes a derived workspace; without any change it is the original workspace itself.

    Attributes:
        labels: share of the training labels of each category that count; the others become oracle labels.
        generated: only shapes in DSG-Net's layout are unlabelled ones.
        is_noisy: scans are taken with the noisy sensor. Shapes and pseudo labels are those of the original workspace.
    """

    labels: float = 1.0
    generated: bool = False
    is_noisy: bool = False

    @property
    def name(self) -> str:
        """Name of the derived workspace's folder; empty for the original workspace."""
        parts = [f"labels-{100.0 * self.labels:g}" if self.labels < 1.0 else "", "generated" if self.generated else ""]
        return "-".join(filter(None, [*parts, "noisy-sensor" if self.is_noisy else ""]))

    def workspace(self, root: Workspace) -> Workspace:
        """The derived workspace, which lies in the original one; nothing is written."""
        if not self.name:
            return root
        path = root.path / "experiments" / self.name
        if self.labels == 1.0 and not self.generated:
            return Workspace(path, prepared=root.prepared, pseudo_labels=root.pseudo_labels, journal=root.journal)
        return Workspace(path, journal=root.journal)

    def labelling(self, root: Workspace) -> Workspace:
        """The workspace that has the motion networks and makes the pseudo labels."""
        return replace(self, is_noisy=False).workspace(root)

    def update(self, root: Workspace) -> Workspace:
        """The derived workspace, with its index of prepared shapes brought up to date."""
        place = self.workspace(root)
        if place.prepared != root.prepared:
            entries = PreparedStore(root.prepared).entries
            folder = os.path.relpath(root.prepared, place.prepared)
            write_index(place.prepared, (replace(entry, file=f"{folder}/{entry.file}") for entry in self._changed(entries)))
        return place

    def _changed(self, entries: Iterable[IndexEntry]) -> list[IndexEntry]:
        found = list(entries)
        if self.generated:
            found = [entry for entry in found if entry.is_labelled or entry.layout == DSG_NET]
        if self.labels < 1.0:
            training = [e for e in found if e.is_labelled and not e.is_oracle and split_of(e.id) is Split.TRAIN]
            kept = within_share(training, self.labels)
            found = [replace(e, is_oracle=True) if e in training and e not in kept else e for e in found]
        return found


def within_share(entries: Iterable[IndexEntry], share: float) -> set[IndexEntry]:
    """A share of the shapes of each category, at least one, chosen by a hash; a smaller share is part of a larger one."""
    ranked: dict[str, list[tuple[float, str, IndexEntry]]] = {}
    for entry in entries:
        ranked.setdefault(entry.category, []).append((_position(entry.id), entry.layout, entry))
    return {
        entry
        for own in ranked.values()
        for _, _, entry in sorted(own, key=lambda item: item[:2])[: max(1, round(share * len(own)))]
    }


def _position(shape_id: str) -> float:
    return int.from_bytes(blake2b(f"share:{shape_id}".encode(), digest_size=8).digest(), "big") / 2.0**64
