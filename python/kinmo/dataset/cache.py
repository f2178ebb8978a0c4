"""The one mechanism that tells whether a result on disk is still current.

A result is current if its *cache key* is the key of what it would be made from now, and its files are still the ones that were
written. A key is a hash of inputs, settings and the version of kinmo.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import Any

from kinmo._core import __version__
from kinmo.core.digest import digest
from kinmo.io.atomic_files import append_line, write_text_atomically

FILE = ".kinmo.jsonl"
"""File of a cache: one JSON object per line; of several lines for one result the last counts."""
_SPARE_LINES = 1000
"""Outdated lines that a file may have beyond twice its results before it is written anew."""


def cache_key(**inputs: Any) -> str:
    """Hash of everything that a result depends on, as plain data in any order. The version of kinmo is added."""
    return digest({**inputs, "kinmo": __version__})


@dataclass(frozen=True)
class Result:
    """A stored result: its `key`, plain `data` that belongs to it, and its `files` with their stamps."""

    key: str
    data: Any = None
    files: Mapping[str, tuple[int, int, str]] = field(default_factory=dict)
    """Size in bytes, time of change in ns and hash of the contents, by path relative to the cache's folder."""


class Cache:
    """The results in one folder, each under a name.

    A result is stored after its files are in place, so that an interrupted run makes it again. Only the process that holds the
    folder's lock may store or forget.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        self._results: dict[str, Result] = {}
        self._lines = 0
        for name, result in _read(self.folder / FILE):
            self._lines += 1
            if result is None:
                self._results.pop(name, None)
            else:
                self._results[name] = result

    def __iter__(self) -> Iterator[str]:
        """Names of all results, current or not."""
        return iter(tuple(self._results))

    def __contains__(self, name: object) -> bool:
        """True if there is a result of this name, current or not."""
        return name in self._results

    def find(self, name: str, *, edited: bool = False) -> Result | None:
        """The result of a name, whatever its key. None if there is none, or one of its files is gone or has changed.

        With `edited`, files may have been edited since they were stored.
        """
        result = self._results.get(name)
        if result is None:
            return None
        files = ((self.folder / path, stamp) for path, stamp in result.files.items())
        is_whole = all(path.is_file() if edited else _is_unchanged(path, stamp) for path, stamp in files)
        return result if is_whole else None

    def data(self, name: str) -> Any:
        """Plain data of a result, current or not; None if there is no such result."""
        result = self._results.get(name)
        return None if result is None else result.data

    def latest(self, name: str) -> Result | None:
        """The result of a name, current or not; None if there is no such result."""
        return self._results.get(name)

    def edited(self, name: str) -> list[Path]:
        """Files of a result that were changed after they were stored. Those that are gone are left out."""
        result = self._results.get(name)
        files = {} if result is None else {self.folder / path: stamp for path, stamp in result.files.items()}
        return [path for path, stamp in files.items() if path.is_file() and not _is_unchanged(path, stamp)]

    def is_current(self, name: str, key: str, *, edited: bool = False) -> bool:
        """True if the result of a name has this key, and its files are the ones that were stored (see `find`)."""
        result = self.find(name, edited=edited)
        return result is not None and result.key == key

    def store(self, name: str, key: str, files: Iterable[Path] = (), data: Any = None) -> None:
        """Store a result, after its files are in place at or below the folder. `data` is plain data that `find` gives back."""
        stamps = {os.path.relpath(path, self.folder): _stamp(path) for path in files}
        result = Result(key, json.loads(json.dumps(data)), stamps)
        if self._results.get(name) == result:
            return
        self._results[name] = result
        self._append(name, result)

    def renew(self, name: str, files: Iterable[Path], kept: Iterable[Path]) -> None:
        """Replace the files of a result, whose key and data stay.

        The stored contents of `files` are their present ones. Those of `kept` stay: these may have been edited.
        """
        known = self._results[name]
        stamps = {path: known.files[path] for each in kept if (path := os.path.relpath(each, self.folder)) in known.files}
        stamps |= {os.path.relpath(path, self.folder): _stamp(path) for path in files}
        if stamps != known.files:
            self._results[name] = Result(known.key, known.data, stamps)
            self._append(name, self._results[name])

    def forget(self, *names: str) -> None:
        """Drop results, before their files change."""
        for name in names:
            if self._results.pop(name, None) is not None:
                self._append(name, None)

    def _append(self, name: str, result: Result | None) -> None:
        self._lines += 1
        if self._lines > 2 * len(self._results) + _SPARE_LINES:
            text = "".join(_line(name, result) + "\n" for name, result in self._results.items())
            write_text_atomically(self.folder / FILE, text)
            self._lines = len(self._results)
        else:
            append_line(self.folder / FILE, _line(name, result))


def _line(name: str, result: Result | None) -> str:
    fields = {} if result is None else {"key": result.key, "data": result.data, "files": dict(result.files)}
    return json.dumps({"name": name, **fields})


def _read(path: Path) -> Iterator[tuple[str, Result | None]]:
    """Names and results in the order of the file; None for a result that was dropped. Damaged lines are left out."""
    try:
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return
    for line in lines:
        try:
            found = json.loads(line)
            files = {name: (int(size), int(time), str(hashed)) for name, (size, time, hashed) in found.get("files", {}).items()}
            yield str(found["name"]), Result(str(found["key"]), found.get("data"), files) if "key" in found else None
        except (ValueError, TypeError, KeyError, AttributeError):
            continue


def _stamp(path: Path) -> tuple[int, int, str]:
    status = path.stat()
    return status.st_size, status.st_mtime_ns, _hash(path)


def _is_unchanged(path: Path, stamp: tuple[int, int, str]) -> bool:
    """True if a file has its old size, and its old time or else its old contents (a copied workspace has other times)."""
    size, time, hashed = stamp
    try:
        status = path.stat()
        return status.st_size == size and (status.st_mtime_ns == time or _hash(path) == hashed)
    except OSError:
        return False


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        hashed = blake2b(digest_size=16)
        while block := file.read(1 << 20):
            hashed.update(block)
    return hashed.hexdigest()
