"""Worker process of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import connection
from multiprocessing.reduction import ForkingPickler
from typing import Any, Literal

from kinmo.dataset.jobs.runner import Failure, Job, Result
from kinmo.dataset.jobs.worker import Owner, attempt, owned_by

Kind = Literal["ready", "message", "allows kill", "result", "error"]
"""Kinds of what a worker sends."""


def serve(function: Callable[[Job], Result], pipe: connection.Connection) -> None:
    """Body of a worker. It ends when the owner closes the pipe, and at once when the owner dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_owner, daemon=True).start()

    def send(kind: Kind, value: Any = None) -> None:
        pipe.send((kind, value))

    def pickled_result(job: Job) -> Any:
        return ForkingPickler.dumps(("result", function(job)))

    owner = Owner(lambda message: send("message", message), lambda: send("allows kill"))
    with suppress(EOFError, BrokenPipeError), owned_by(owner):
        send("ready")
        while True:
            job = pipe.recv()
            try:
                result = attempt(pickled_result, job)
            except BaseException as error:
                send("error", error)
            else:
                send("result", result) if isinstance(result, Failure) else pipe.send_bytes(result)


def _end_with_owner() -> None:
    owner = multiprocessing.parent_process()
    if owner is not None:
        connection.wait([owner.sentinel])
        os._exit(1)
