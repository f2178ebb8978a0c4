"""The folder in which the stages of kinmo keep what they make.

A file in it is either whole or absent: everything is written beside its place and renamed. A stage writes its record last;
a record says from what the stage made its files, and what was in them, so that the same stage with the same inputs has nothing
left to do, unless a file has gone or was damaged since.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.io.atomic_files import write_text_atomically
from kinmo.io.file_memo import kept_while_unchanged
from kinmo.io.folder_lock import locked

DEFAULT_METHOD = "kinmo"
"""Whose pseudo labels are meant where nothing is said."""


@dataclass(frozen=True)
class StageRecord:
    """What a stage made from what. `inputs` is plain data; `outputs` are paths relative to the workspace."""

    inputs: Mapping[str, Any]
    outputs: tuple[str, ...] = ()
    kinmo: str = __version__


class Workspace:
    """A workspace. `prepared`, `models`, `pseudo`, `scans`, `evaluation` and `report` are the folders of the stages; what is
    not trained to the end is in `training`, in folders as those in `models`.

    `labels` is the share of the labelled shapes for training whose labels count. A workspace with fewer than all of them lies
    in another one, its `root`: it has that one's prepared shapes and scans, and everything that labels decide is its own, such
    as scans of what has no label (`own_scans`). One that `is_rough`, too, is within another, for scans as a bad sensor takes
    them, and all that is made from these; pseudo labels, for which no scan is seen, are that one's (`labelling`). One of
    another `method` than the default lies in that of the default one: it has the pseudo labels that this method gives, and what
    is made from them, but no motion networks of its own (`motion`).
    """

    def __init__(self, path: Path | str, labels: float = 1.0, is_rough: bool = False, method: str = DEFAULT_METHOD) -> None:
        self.root = Path(path)
        self.labels, self.is_rough, self.method = labels, is_rough, method
        seen = self.root / "rough" if is_rough else self.root
        labelled = Path() if labels == 1.0 else Path(f"labels-{100.0 * labels:g}")
        if method != DEFAULT_METHOD:
            labelled /= f"by-{method}"
        self.path = seen / labelled
        self.scans = seen / "scans"
        self.prepared = self.root / "prepared"
        self.models = self.path / "models"
        self.training = self.path / "training"
        self.pseudo = self.root / labelled / "pseudo"
        self.own_scans = self.path / "own-scans"
        self.evaluation = self.path / "eval"
        self.report = self.path / "report"
        self._records = self.path / "records"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Workspace) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)

    @property
    def _key(self) -> tuple[Path, float, bool, str]:
        return self.root, self.labels, self.is_rough, self.method

    @property
    def labelling(self) -> Workspace:
        """The one that has the pseudo labels, whatever sensor scans are by."""
        return Workspace(self.root, self.labels, method=self.method)

    @property
    def motion(self) -> Workspace:
        """The one that has the motion networks, which all methods share."""
        return self.labelling.by(DEFAULT_METHOD)

    @property
    def without_pseudo_labels(self) -> Workspace:
        """The one with networks that saw no pseudo label, and scans of what has no label."""
        return self.by(DEFAULT_METHOD)

    def by(self, method: str) -> Workspace:
        """The one with the pseudo labels of a method, beside this."""
        return Workspace(self.root, self.labels, self.is_rough, method)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keeps other kinmo processes from writing here (`locked`)."""
        with locked(self.root):
            yield

    def record(self, stage: str) -> StageRecord | None:
        """What `stage` wrote last; None if it never finished, or its record cannot be read."""
        found = self._read_record(stage)
        return None if found is None else found[0]

    def _read_record(self, stage: str) -> tuple[StageRecord, dict[str, str | None]] | None:
        """The record of `stage`, and the hashes of its outputs."""
        try:
            data = json.loads((self._records / f"{stage}.json").read_text(encoding="utf-8"))
            hashes = dict(data["outputs"])
            return StageRecord(data["inputs"], tuple(hashes), data["kinmo"]), hashes
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def write_record(self, stage: str, record: StageRecord) -> None:
        """Says that `stage` is finished. To be called when all its outputs are in place."""
        outputs = {output: _hash(self.path / output) for output in record.outputs}
        data = {"inputs": _plain(record.inputs), "outputs": outputs, "kinmo": record.kinmo}
        write_text_atomically(self._records / f"{stage}.json", json.dumps(data, indent=1, sort_keys=True) + "\n")

    def forget(self, stage: str) -> None:
        """Drops the record of `stage`: to be called before its outputs change."""
        (self._records / f"{stage}.json").unlink(missing_ok=True)

    def is_current(self, stage: str, inputs: Mapping[str, Any]) -> bool:
        """Whether `stage` was finished by this version of kinmo from just these inputs, and its outputs are still the same."""
        found = self._read_record(stage)
        if found is None or found[0].kinmo != __version__ or found[0].inputs != _plain(inputs):
            return False
        return all(before is not None and _hash(self.path / output) == before for output, before in found[1].items())


def _plain(value: Mapping[str, Any]) -> Any:
    """`value` as JSON gives it back."""
    return json.loads(json.dumps(value))


@kept_while_unchanged
def _hash(path: Path) -> str | None:
    """A hash of a file's contents; None if it cannot be read."""
    try:
        return blake2b(path.read_bytes(), digest_size=16).hexdigest()
    except OSError:
        return None
