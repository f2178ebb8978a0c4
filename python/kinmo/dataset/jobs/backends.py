"""Choice of the backend."""

from __future__ import annotations

from kinmo.dataset.jobs.cluster import RayRunner
from kinmo.dataset.jobs.local import LocalRunner
from kinmo.dataset.jobs.runner import JobRunner


def runner_for(
    workers: int, cluster: str | None = None, *, jobs_per_worker: int = 0, threads: int = 1, gpus: float = 0.0
) -> JobRunner:
    """Runner of jobs on a Ray cluster if there is an address of one, else on this machine.

    Args:
        workers: Number of processes on this machine.
        cluster: Address of a Ray cluster, "auto", or "local" (see `RayRunner`).
        jobs_per_worker: On this machine, start at most one process for so many jobs.
        threads: On this machine, threads of each job.
        gpus: On a cluster, the share of a GPU that each job needs.

    Returns:
        A runner whose results do not depend on the choice.

    Example:
        >>> runner_for(workers=4)
        LocalRunner(workers=4, jobs_per_worker=0, threads=1)
    """
    return RayRunner(cluster, gpus) if cluster else LocalRunner(workers, jobs_per_worker, threads)
