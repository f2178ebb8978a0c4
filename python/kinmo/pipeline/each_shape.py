"""Work that asks networks about many shapes, on several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeVar

import torch

from kinmo.dataset.workers import Crashed, map_unordered, or_crashed
from kinmo.learning.weights import processes_on

Job = TypeVar("Job")
Answer = TypeVar("Answer")

JOBS_A_PROCESS = 4
"""A process is not worth its start for fewer: it imports torch and reads networks for as long as a few shapes take."""


def each_shape(
    work: Callable[[Job], Answer], jobs: Sequence[Job], workers: int, device: str
) -> Iterator[tuple[Job, Answer | Crashed]]:
    """`work` of every job, as the answers come (`workers.map_unordered`); `work` must be fit to be pickled.

    What it raises at one job, but for a KinmoError, ends that job alone.

    Networks get one thread a process, in this one too, so that answers do not depend on `workers`.
    """
    workers = processes_on(device, workers)
    threads = torch.get_num_threads()
    try:
        yield from map_unordered(partial(_on_one_thread, work), jobs, min(workers, len(jobs) // JOBS_A_PROCESS))
    finally:
        torch.set_num_threads(threads)


def _on_one_thread(work: Callable[[Job], Answer], job: Job) -> Answer | Crashed:
    torch.set_num_threads(1)
    return or_crashed(work, job)
