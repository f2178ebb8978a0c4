"""Surroundings of a job: isolation of its failures, and its connection to the owner of the run."""

from __future__ import annotations

import errno
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinmo.core.errors import KinmoError
from kinmo.dataset.jobs.runner import Failure, Job, Result

DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""The disk is full, or read-only: the next job would fail too."""
THREAD_VARIABLES = ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that libraries read the number of their threads from."""


@dataclass(frozen=True)
class Owner:
    """The process that started a run, as a running job sees it."""

    report: Callable[[Any], None] = lambda message: None
    allow_kill: Callable[[], None] = lambda: None


_owner = Owner()


@contextmanager
def owned_by(owner: Owner) -> Iterator[None]:
    """Connect the jobs that run in the block to their owner."""
    global _owner
    outer, _owner = _owner, owner
    try:
        yield
    finally:
        _owner = outer


def report(message: Any) -> None:
    """Send a message from a running job to the `on_message` of its run. Outside of a run it does nothing.

    Args:
        message: Any picklable value. The message arrives before the job's result.

    Example:
        >>> def train(name):
        ...     for epoch in range(10):
        ...         report((name, epoch))
    """
    _owner.report(message)


def allow_kill() -> None:
    """Let the runner kill the running job at once when the run ends early. The job's files must be whole at any moment.

    Example:
        >>> def train(name):
        ...     allow_kill()
        ...     train_for_hours(name)
    """
    _owner.allow_kill()


def attempt(function: Callable[[Job], Result], job: Job) -> Result | Failure:
    """Result of one job, or a `Failure` if it raises something unforeseen. Panics of the Rust core count, though no Exceptions.

    Raises:
        KinmoError, KeyboardInterrupt, SystemExit: As raised by the job.
        OSError: The disk is full or read-only.
    """
    try:
        return function(job)
    except (KinmoError, KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:
        if isinstance(error, OSError) and error.errno in DISK_ERRORS:
            raise
        where = traceback.extract_tb(error.__traceback__)[-1]
        return Failure(f"{type(error).__name__} at {Path(where.filename).name}:{where.lineno}: {error}")
