"""Workspaces derived from another one: with fewer labels, with other unlabelled shapes, or with scans of a noisy sensor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from kinmo.dataset.splits import Split, hashed_position, leaks, split_of
from kinmo.dataset.store import IndexEntry
from kinmo.dataset.workspace import Workspace
from kinmo.io.readers import DSG_NET


@dataclass(frozen=True)
class Variant:
    """Change that makes a derived workspace. Without any change it stands for the original workspace itself."""

    labels: float = 1.0  # share of the training labels of each category that count; the others become oracle labels
    generated: bool = False  # only shapes in DSG-Net's layout are unlabelled ones
    is_noisy: bool = False  # scans, but not shapes and pseudo labels, are those of the noisy sensor

    @property
    def name(self) -> str:
        """Name of the derived workspace's folder; empty for the original workspace."""
        parts = [f"labels-{100.0 * self.labels:g}" if self.labels < 1.0 else "", "generated" if self.generated else ""]
        return "-".join(filter(None, [*parts, "noisy-sensor" if self.is_noisy else ""]))

    def workspace(self, root: Workspace) -> Workspace:
        """The derived workspace, which lies in the original one and shares its prepared shapes; nothing is written."""
        if not self.name:
            return root
        is_selected = self.labels < 1.0 or self.generated
        has_own_labels = self == Variant(self.labels)
        return Workspace(
            root.path / "experiments" / self.name,
            prepared=root.prepared,
            pseudo_labels=None if has_own_labels else self.labelling(root).pseudo_labels,
            journal=root.journal,
            select=ShapeSelection(self.labels, self.generated) if is_selected else None,
        )

    def labelling(self, root: Workspace) -> Workspace:
        """The workspace that trains the motion networks and makes the pseudo labels: only the share of labels matters."""
        return Variant(self.labels).workspace(root)


@dataclass(frozen=True)
class ShapeSelection:
    """Function that gives the entries of a derived workspace (`Workspace.select`); its attributes are those of `Variant`."""

    labels: float
    generated: bool

    def __call__(self, entries: Sequence[IndexEntry]) -> Sequence[IndexEntry]:
        """Entries of the derived workspace, from those of the original one."""
        if self.generated:
            entries = _with_generated_shapes(entries)
        if self.labels < 1.0:
            training = [e for e in entries if e.is_labelled and not e.is_oracle and split_of(e.id) is Split.TRAIN]
            hidden = set(training) - within_share(training, self.labels)
            entries = [replace(entry, is_oracle=True) if entry in hidden else entry for entry in entries]
        return entries


def _with_generated_shapes(entries: Sequence[IndexEntry]) -> list[IndexEntry]:
    """Labelled shapes, and unlabelled ones in DSG-Net's layout. Oracle labels stay only for copies of these."""
    generated = [entry for entry in entries if not entry.is_labelled and entry.layout == DSG_NET]
    oracle = [entry for entry in entries if entry.is_labelled and entry.is_oracle and split_of(entry.id) is not Split.TEST]
    alone = {entry for entry, has_copy in zip(oracle, leaks(oracle, generated, ()), strict=True) if not has_copy}
    kept = set(generated)
    return [entry for entry in entries if entry in kept or (entry.is_labelled and entry not in alone)]


def within_share(entries: Iterable[IndexEntry], share: float) -> set[IndexEntry]:
    """A share of the shapes of each category, at least one, chosen by a hash; a smaller share is part of a larger one."""
    ranked: dict[str, list[tuple[float, str, IndexEntry]]] = {}
    for entry in entries:
        ranked.setdefault(entry.category, []).append((hashed_position(entry.id, "share"), entry.layout, entry))
    return {
        entry
        for own in ranked.values()
        for _, _, entry in sorted(own, key=lambda item: item[:2])[: max(1, round(share * len(own)))]
    }
