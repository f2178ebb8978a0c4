"""The interface between runners and their jobs: results, messages, and isolation of failures."""

from __future__ import annotations

import errno
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from kinmo.core.errors import KinmoError

Job = TypeVar("Job")
Result = TypeVar("Result")

DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""The disk is full, or read-only: the next job would fail too."""
THREAD_VARIABLES = ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that libraries read the number of their threads from."""


@dataclass(frozen=True)
class Failure:
    """The result of a job that failed in a way nobody foresaw, with the reason in one line for the user."""

    reason: str


class JobRunner(Protocol):
    """Runs one function over many jobs. A job is one picklable value that the function is called with."""

    def run(
        self, function: Callable[[Job], Result], jobs: Iterable[Job], on_message: Callable[[Any], None] | None = None
    ) -> Generator[tuple[Job, Result | Failure], None, None]:
        """Run `function` over all jobs.

        Only a few jobs per worker are taken from `jobs` ahead of time: memory does not grow with their number.
        Ctrl-C and closing the generator end the run. Waiting jobs are dropped, and running jobs finish. Jobs that called
        `allow_kill` are killed. A second Ctrl-C kills all.

        Args:
            function: A picklable function that workers can import by name.
            jobs: Picklable values.
            on_message: Takes what running jobs `report`, in the caller's thread, while the caller waits for results.

        Yields:
            Each job with its result, in order of completion. The result is a `Failure` if the job raised something unforeseen,
            panicked in Rust, or killed its process again when it was repeated.

        Raises:
            KinmoError: A job raised it. It ends the run, as KeyboardInterrupt and SystemExit do.
            OSError: A job found the disk full or read-only.
            ChildProcessError: No worker could start.
        """


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
    """Send a picklable message from a running job to the `on_message` of its run. It arrives before the job's result.

    Outside of a run it does nothing.
    """
    _owner.report(message)


def allow_kill() -> None:
    """Let the runner kill the running job at once when the run ends early. The job's files must be whole at any moment."""
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
