"""Jobs in a Ray worker."""

from __future__ import annotations

import os
import platform
import signal
import socket
import threading
from collections.abc import Callable
from functools import lru_cache
from importlib import import_module
from typing import Any

from kinmo._core import __version__
from kinmo.dataset.jobs.worker import THREAD_VARIABLES, Owner, attempt, owned_by


def perform(function: list[Any], version: str, box: Any, job: bytes) -> tuple[BaseException | str | None, Any]:
    """Run a pickled job in a Ray worker. Returns what ends the run, or None, and the result."""
    if version != __version__:
        return f"{platform.node()} has kinmo {__version__}, expected {version}. Install {version} on all nodes", None
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # with which Ray cancels
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    loads = import_module("ray").cloudpickle.loads
    try:
        with owned_by(Owner(Owner().report if box is None else box.put, _allow_kill)):
            return None, attempt(lambda data: _loaded(function[0])(loads(data)), job)
    except BaseException as error:
        return error, None


@lru_cache(maxsize=1)
def _loaded(function: Any) -> Callable[[Any], Any]:
    """The function of a run. A worker loads it once."""
    loaded: Callable[[Any], Any] = import_module("ray").get(function)
    return loaded


def _allow_kill() -> None:
    """End the process at once when Ray cancels the job, also in a library, where no handler of Python runs."""
    signal.signal(signal.SIGINT, lambda number, frame: None)
    _exit_on_signal()


@lru_cache(maxsize=1)
def _exit_on_signal() -> None:
    heard, said = socket.socketpair()
    said.setblocking(False)
    signal.set_wakeup_fd(said.fileno())
    threading.Thread(target=lambda: (heard.recv(1), os._exit(1), said), daemon=True).start()
