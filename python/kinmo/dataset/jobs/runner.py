"""The interface of all job runners."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Failure:
    """The result of a job that failed in a way nobody foresaw.

    Args:
        reason: One line for the user.
    """

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

        Example:
            >>> for path, result in LocalRunner(workers=4).run(prepare, paths):
            ...     print(path, result.reason if isinstance(result, Failure) else "prepared")
        """
