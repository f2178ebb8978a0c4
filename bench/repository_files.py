"""Files of a GitHub repository: from a clone, a git folder or an unpacked archive, without a change of it."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from kinmo.core.errors import InputError
from kinmo.io.readers.untrusted_files import inside

MODEL_ENDINGS = (".urdf", ".sdf", ".xml", ".obj", ".stl", ".ply", ".msh", ".dae", ".glb", ".gltf", ".bin")
"""Endings of the files that are unpacked: robot files and meshes, but no textures."""


def find_repository(folder: Path, repository: str) -> Path | None:
    """The place of the repository OWNER/NAME: OWNER+NAME, OWNER/NAME or NAME in `folder`, or `repo` in one of these.

    Args:
        folder: The folder that has clones or git folders.
        repository: OWNER/NAME.

    Returns:
        A clone, a git folder or a folder of files. None if there is none.
    """
    places = [folder / name for name in (repository.replace("/", "+"), repository, repository.partition("/")[2])]
    candidates = [inner for place in places for inner in (place / "repo", place) if inner.is_dir()]
    return next((place for place in candidates if _has_git(place)), candidates[-1] if candidates else None)


def unpack(place: Path, commit: str, paths: Sequence[str], out: Path) -> str:
    """Copy the robot files and meshes of a repository. Files that the repository lists but lacks are left out.

    Args:
        place: A clone, a git folder or a folder of files.
        commit: The commit to take. The newest one is taken if the clone does not have it.
        paths: The files and folders to copy.
        out: The folder to copy them into.

    Returns:
        The commit that was taken. Empty for a folder without git.

    Raises:
        InputError: The clone cannot be read, or a path leads out of `out`.
    """
    if not _has_git(place):
        for source in _files(place, paths):
            target = out / source.relative_to(place)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
        return ""
    has_commit = _git(place, "cat-file", "-e", f"{commit}^{{commit}}").returncode == 0
    taken = commit if has_commit else _output(place, "rev-parse", "HEAD").decode().strip()
    rows = _output(place, "ls-tree", "-r", "-z", taken, "--", *paths).decode("utf-8", "replace").split("\0")
    blobs = []
    for row in filter(None, rows):
        facts, name = row.split("\t", 1)
        mode, kind, blob = facts.split()
        if kind == "blob" and mode != "120000" and _is_model(PurePosixPath(name)):  # 120000 is a link
            blobs.append((blob, inside(out / name, out)))
    data = _output(place, "cat-file", "--batch", given="".join(f"{blob}\n" for blob, _ in blobs).encode())
    start = 0
    for _, target in blobs:
        end = data.index(b"\n", start)
        words, start = data[start:end].split(), end + 1
        if words[-1] == b"missing":
            continue
        size = int(words[-1])
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data[start : start + size])
        start += size + 1
    return taken


def _has_git(place: Path) -> bool:
    return (place / ".git").exists() or ((place / "HEAD").is_file() and (place / "objects").is_dir())


def _is_model(path: Path | PurePosixPath) -> bool:
    return path.suffix.lower() in MODEL_ENDINGS


def _files(place: Path, paths: Sequence[str]) -> Iterator[Path]:
    """The robot files and meshes at or below the paths."""
    for path in paths:
        top = place / path
        yield from (file for file in (top, *top.rglob("*")) if file.is_file() and _is_model(file))


def _git(place: Path, *arguments: str, given: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    try:
        return subprocess.run(["git", "-C", str(place), *arguments], input=given, capture_output=True, check=False)
    except OSError as error:
        raise InputError(place, f"expected the program git ({error.strerror})") from None


def _output(place: Path, *arguments: str, given: bytes = b"") -> bytes:
    """The output of a command of git. Raises InputError if it fails."""
    done = _git(place, *arguments, given=given)
    if done.returncode:
        raise InputError(place, f"git {arguments[0]} failed: {done.stderr.decode('utf-8', 'replace').strip()}")
    return done.stdout
