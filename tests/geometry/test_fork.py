"""Forked processes, which have no threads but the one that forked."""

from __future__ import annotations

import os
import signal
import time

import numpy as np
import pytest

from kinmo import _core

SECONDS = 60.0


def _status_of_child(process: int) -> int:
    """Exit status of a child; one that takes too long is killed."""
    deadline = time.monotonic() + SECONDS
    while time.monotonic() < deadline:
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    raise TimeoutError(f"the forked process has not ended after {SECONDS:g} s")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no os.fork")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*fork:DeprecationWarning")
def test_forked_processes_compute_the_same() -> None:
    clouds = np.random.default_rng(0).uniform(size=(50, 40, 3)).astype(np.float32)
    expected = _core.nearest_neighbours(clouds, 5)
    process = os.fork()
    if process == 0:
        same = False
        try:
            same = np.array_equal(_core.nearest_neighbours(clouds, 5), expected)
        finally:
            os._exit(0 if same else 1)
    assert _status_of_child(process) == 0
