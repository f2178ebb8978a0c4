"""The folder in which the stages of kinmo keep what they make.

A file in it is either whole or absent: everything is written beside its place and renamed. A stage writes its record last;
a record says from what the stage made its files, and what was in them, so that the same stage with the same inputs has nothing
left to do, unless a file has gone or was damaged since.
"""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar
from urllib.parse import quote

from kinmo import __version__
from kinmo.errors import InputError, KinmoError

_TEMPORARY = ".{name}.tmp~"
_REPLACED = ".{name}.old~"
LONGEST_NAME = 150
"""Bytes of a name on disk: what comes before and after it has room in the 255 that there are."""
DEFAULT_METHOD = "kinmo"
"""Whose pseudo labels are meant where nothing is said."""
_SETTLED = 2_000_000_000
"""Nanoseconds, longer than a tick of the clock of any file system."""

Value = TypeVar("Value")


@contextmanager
def write_atomically(path: Path) -> Iterator[Path]:
    """Gives a place to write a file or a folder, and moves it to `path` once the block is done.

    Whatever happens in between, `path` is what it was before, or (for a folder that is replaced) absent, or whole. The
    temporary place has a fixed name beside `path`, so that a run that was killed leaves nothing that the next one does not
    clear away.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.parent / _TEMPORARY.format(name=path.name)
    replaced = path.parent / _REPLACED.format(name=path.name)
    _remove(temporary)
    try:
        yield temporary
        if not os.path.lexists(temporary):
            raise FileNotFoundError(f"nothing was written to {temporary}")
        _sync(temporary)
        if path.is_dir() and not path.is_symlink():
            _remove(replaced)
            path.rename(replaced)
        temporary.replace(path)
        _sync_folder(path.parent)
    except OSError as error:
        if error.errno is not None and error.filename in (None, str(temporary)):  # writing to a full disk names no file
            error.filename = str(path)
        raise
    finally:
        _remove(temporary)
        _remove(replaced)


def write_text_atomically(path: Path, text: str) -> None:
    """Writes a UTF-8 file with `write_atomically`; one that has this text already is left alone."""
    write_bytes_atomically(path, text.encode("utf-8"))


def write_bytes_atomically(path: Path, data: bytes) -> None:
    """Writes a file with `write_atomically`; one that has these contents already is left alone."""
    if _contents(path) == data:
        return
    with write_atomically(path) as temporary:
        temporary.write_bytes(data)


class InUse(KinmoError):
    """Another process writes into a folder: nothing can be done there now."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Makes `folder`, if need be, and keeps other kinmo processes from writing there.

    The system frees the lock of a process that dies, however it dies. Raises InUse if another process holds the lock, and
    InputError if the folder cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise InputError(folder, f"cannot be written to ({error.strerror})") from None
    try:
        if not _lock(handle):
            holder = os.pread(handle, 32, 0).decode("ascii", "replace").strip() or "unknown"
            raise InUse(folder, f"another kinmo (process {holder}) is writing here: wait for it, or name another folder")
        os.ftruncate(handle, 0)
        os.pwrite(handle, f"{os.getpid()}\n".encode(), 0)
        yield
        os.ftruncate(handle, 0)
    finally:
        os.close(handle)


def check_can_be_written(folder: Path) -> None:
    """Raises InputError if nothing can be written to a folder, or it cannot be made; makes nothing."""
    there = next(path for path in (folder, *folder.absolute().parents) if os.path.lexists(path))
    if not there.is_dir():
        raise InputError(folder, "expected a folder: this is a file" if there == folder else f"{there} is a file, not a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(folder, "cannot be written to")


def remove_leftovers(folder: Path) -> None:
    """Clears away what runs that were killed left in `folder` and below. Only for the holder of the workspace's lock."""
    for pattern in (_TEMPORARY, _REPLACED):
        for path in Path(folder).rglob(pattern.format(name="*")):
            _remove(path)


def name_on_disk(text: str) -> str:
    """A name for a file or folder, without ending, with nothing in it that a file system minds: another one for other text."""
    return short_name(quote(text, safe=" "), text)


def short_name(name: str, text: str) -> str:
    """`name`, for a file or folder, which stands for `text`: if it is too long it is cut, and told from others by a hash."""
    encoded = name.encode()
    return name if len(encoded) <= LONGEST_NAME else f"{encoded[:LONGEST_NAME].decode(errors='ignore')}~{digest(text)}"


def digest(value: object) -> str:
    """A hash (32 hex digits) of plain data: the same for equal values, whatever the order of keys."""
    return blake2b(json.dumps(value, sort_keys=True, separators=(",", ":")).encode(), digest_size=16).hexdigest()


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


def _contents(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except OSError:
        return None


def kept_while_unchanged(read: Callable[[Path], Value]) -> Callable[[Path], Value]:
    """Keeps what `read` gave of a file for as long as the file stays as it is. Nobody may change what was given.

    Nothing is kept of a file that has just changed: it could change again and look the same, since clocks of file systems tick
    slowly.
    """
    known: dict[Path, tuple[tuple[int, ...], Value]] = {}

    @wraps(read)
    def reading(path: Path) -> Value:
        try:
            found = path.stat()
        except OSError:
            return read(path)  # which tells it in its own words
        stamp = found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
        kept = known.get(path)
        if kept is not None and kept[0] == stamp:
            return kept[1]
        is_settled = time.time_ns() - found.st_ctime_ns > _SETTLED
        value = read(path)
        if is_settled:
            known[path] = stamp, value
        return value

    return reading


@kept_while_unchanged
def _hash(path: Path) -> str | None:
    """A hash of a file's contents; None if it cannot be read."""
    contents = _contents(path)
    return None if contents is None else blake2b(contents, digest_size=16).hexdigest()


def _lock(handle: int) -> bool:
    """Whether the lock on an open file was free. Without fcntl (Windows) there are no locks."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _sync(path: Path) -> None:
    """Brings a file, or all of a folder, to the disk."""
    if path.is_dir():
        for below in path.rglob("*"):
            if below.is_file():
                _sync_file(below)
    else:
        _sync_file(path)


def _sync_file(path: Path) -> None:
    with path.open("rb+") as file:
        os.fsync(file.fileno())


def _sync_folder(path: Path) -> None:
    if os.name != "posix":
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
