"""The folder in which the stages of kinmo keep their results."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kinmo.dataset.cache import Cache, cache_key
from kinmo.io.folder_lock import locked

if TYPE_CHECKING:
    from kinmo.dataset.store import IndexEntry

Selection = Callable[["Sequence[IndexEntry]"], "Sequence[IndexEntry]"]
"""Function of all prepared shapes that gives those of a workspace. It can be pickled and compared."""


class Workspace:
    """Folders of one workspace, and the cache that tells which of its stages are up to date.

    Every file in a workspace is whole or absent. A stage records its inputs after its outputs are in place; the same stage with
    the same inputs then has nothing left to do.

    Attributes:
        path: the folder itself; it need not exist.
        prepared: prepared shapes and their index, perhaps shared with another workspace.
        models: trained networks.
        training: networks whose training is not finished, in folders like those of `models`.
        pseudo_labels: predicted joints of unlabelled shapes, a folder for each method, perhaps shared.
        scans: depth scans, a folder for each category.
        evaluation: scores and tables.
        report: the HTML report.
        journal: file that records all runs, perhaps shared.
        select: function that chooses among shared prepared shapes, or changes their entries; None for all as they are.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        prepared: Path | None = None,
        pseudo_labels: Path | None = None,
        journal: Path | None = None,
        select: Selection | None = None,
    ) -> None:
        self.path = Path(path)
        self.prepared = prepared or self.path / "prepared"
        self.models = self.path / "models"
        self.training = self.path / "training"
        self.pseudo_labels = pseudo_labels or self.path / "pseudo_labels"
        self.scans = self.path / "scans"
        self.evaluation = self.path / "evaluation"
        self.report = self.path / "report"
        self.journal = journal or self.path / "journal.jsonl"
        self.select = select

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Workspace) and self._identity == other._identity

    def __hash__(self) -> int:
        return hash(self._identity)

    @property
    def _identity(self) -> tuple[Path | Selection | None, ...]:
        return self.path, self.prepared, self.pseudo_labels, self.journal, self.select

    def locked(self) -> AbstractContextManager[None]:
        """Keep other processes from writing here inside the block (see `kinmo.io.folder_lock.locked`)."""
        return locked(self.path)

    def is_current(self, stage: str, inputs: Mapping[str, Any]) -> bool:
        """True if a stage was finished with these inputs by this version of kinmo, and its outputs have not changed since."""
        return Cache(self.path).is_current(stage, cache_key(**inputs))

    def inputs_of(self, stage: str) -> dict[str, Any] | None:
        """The inputs with which a stage was finished; None if it was not, or one of its outputs has changed."""
        found = Cache(self.path).find(stage)
        return None if found is None or not isinstance(found.data, dict) else found.data

    def record(self, stage: str, inputs: Mapping[str, Any], outputs: Iterable[Path] = ()) -> None:
        """Record that a stage is finished, after its outputs are in place. They depend on `inputs` (plain data) alone."""
        Cache(self.path).store(stage, cache_key(**inputs), outputs, inputs)

    def forget(self, stage: str) -> None:
        """Drop the record of a stage, before its outputs change."""
        Cache(self.path).forget(stage)
