"""Convex pieces of surfaces by CoACD, in processes of their own, and remembered in the user's cache folder.

Source: Wei et al., "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search", SIGGRAPH
2022.
"""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from hashlib import blake2b
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from kinmo.core.shape import Mesh
from kinmo.robot import coacd_process

Points = NDArray[np.float64]

MAX_SECONDS = 3.0
"""Most processor time for one surface, in seconds."""
MAX_SECONDS_PER_PROCESS = 4.0
"""Most processor time for the surfaces of an object in each process, in seconds."""
MAX_PROCESSES = 2
PIECES_PER_PROCESS = 4
"""Surfaces that are worth a second process."""
FAILURE_SIGNALS = ("SIGSEGV", "SIGABRT", "SIGPROF", "SIGXCPU")
"""Signals that end the process if CoACD crashes on a surface or takes too long. SIGKILL is not one: it comes from outside, such
as when memory is short."""
CACHE_FOLDER = "KINMO_CACHE"
"""Environment variable that names another cache folder."""


def is_installed() -> bool:
    """True if CoACD can be imported. Its import is not tried, since it takes a while."""
    try:
        importlib.metadata.version("coacd")
    except importlib.metadata.PackageNotFoundError:
        return False
    return True


def cache_folder() -> Path:
    """Folder of the pieces that are remembered, in the user's cache."""
    own = os.environ.get(CACHE_FOLDER)
    if own:
        return Path(own)
    place = os.environ.get("XDG_CACHE_HOME")
    try:
        return (Path(place) if place else Path.home() / ".cache") / "kinmo"
    except RuntimeError:  # the user has no home
        return Path(tempfile.gettempdir()) / "kinmo"


def divided(surfaces: Sequence[Mesh]) -> list[list[Points] | None]:
    """Convex pieces of some surfaces.

    Args:
        surfaces: Surfaces in any length unit. Each is divided at its own scale.

    Returns:
        For each surface the corners [P, 3] of its pieces. None if CoACD failed or took more than `MAX_SECONDS`, which is
        remembered. None too if there was no time left for it, or CoACD could not run: this is tried again the next time. The
        smallest surfaces come first.
    """
    folder = cache_folder() / "coacd"
    keys = [_key(surface) for surface in surfaces]
    known = {key: pieces for key in dict.fromkeys(keys) if (pieces := _read(folder / f"{key}.npz")) is not None}
    missing = {key: surface for key, surface in zip(keys, surfaces, strict=True) if key not in known}
    for key, pieces in zip(missing, _run(list(missing.values())), strict=True):
        if pieces is not None:
            known[key] = pieces
            _remember(folder / f"{key}.npz", pieces)
    return [known.get(key) or None for key in keys]


def _key(surface: Mesh) -> str:
    settings = repr((importlib.metadata.version("coacd"), coacd_process.SETTINGS, MAX_SECONDS)).encode()
    content = surface.vertices.astype("<f8").tobytes(), surface.faces.astype("<u4").tobytes()
    return blake2b(b"".join((settings, *content)), digest_size=16).hexdigest()


def _run(surfaces: Sequence[Mesh]) -> list[list[Points] | None]:
    """Pieces of surfaces. Empty where CoACD fails, None where it did not run or had no time."""
    if not surfaces:
        return []
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for number, surface in enumerate(surfaces):
            np.savez(folder / f"{number}.npz", vertices=surface.vertices, faces=surface.faces)
        processes = min(MAX_PROCESSES, os.cpu_count() or 1, 1 + len(surfaces) // PIECES_PER_PROCESS)
        smallest_first = sorted(range(len(surfaces)), key=lambda number: len(surfaces[number].faces))
        with ThreadPoolExecutor(processes) as pool:
            failed = pool.map(lambda first: _run_all(folder, smallest_first[first::processes]), range(processes))
            failures = {number for numbers in failed for number in numbers}
        return [[] if number in failures else _read(folder / f"{number}.pieces.npz") for number in range(len(surfaces))]


def _run_all(folder: Path, numbers: Sequence[int]) -> list[int]:
    """Divide surfaces in one process, and in a new one after each surface that ends it. Returns those that CoACD fails on."""
    environment = os.environ | {"OMP_NUM_THREADS": "1"}  # more threads wait for each other most of the time
    left, seconds = list(numbers), MAX_SECONDS_PER_PROCESS
    failures: list[int] = []
    while left and seconds > 0.0:
        limits = (str(MAX_SECONDS), str(seconds))
        command = [sys.executable, coacd_process.__file__, str(folder), *limits, *map(str, left)]
        with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        seconds -= usage.ru_utime + usage.ru_stime
        while left and (folder / f"{left[0]}.pieces.npz").exists():
            left.pop(0)
        if process.returncode == 0 or not left or not (folder / f"{left[0]}.started").exists():
            break  # all are done, the time is spent, or CoACD does not run at all
        ended = left.pop(0)
        if _is_failure(process.returncode):
            failures.append(ended)
    return failures


def _is_failure(code: int) -> bool:
    """True for the exit code of a process in which CoACD failed on the surface that it had."""
    signals = {-getattr(signal, name) for name in FAILURE_SIGNALS if hasattr(signal, name)}  # Windows lacks some
    return code == coacd_process.CANNOT_DIVIDE or code in signals


def _read(path: Path) -> list[Points] | None:
    """Pieces in a file. None if it is missing or damaged."""
    try:
        with np.load(path) as file:
            points, counts = file["points"], file["counts"]
        return np.split(points, np.cumsum(counts)[:-1]) if len(counts) else []
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        return None


def _remember(path: Path, pieces: Sequence[Points]) -> None:
    """Write pieces into the cache. A full or read-only disk only costs time later."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as place:
            draft = Path(place) / "pieces.npz"
            np.savez(
                draft, points=np.concatenate([np.zeros((0, 3)), *pieces]), counts=np.array([len(each) for each in pieces], int)
            )
            shutil.move(draft, path)
    except OSError:
        return
