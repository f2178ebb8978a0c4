"""One job runner with two backends: processes of this machine, and a Ray cluster."""

from __future__ import annotations

from kinmo.dataset.jobs.cluster import RayRunner
from kinmo.dataset.jobs.local import LocalRunner
from kinmo.dataset.jobs.runner import Failure, JobRunner, allow_kill, report

__all__ = ["Failure", "JobRunner", "LocalRunner", "RayRunner", "allow_kill", "report", "runner_for"]


def runner_for(
    workers: int, cluster: str | None = None, *, jobs_per_worker: int = 0, threads: int = 1, gpus: float = 0.0
) -> JobRunner:
    """Runner on a Ray cluster if there is an address of one, else on this machine. The choice does not change results.

    Args:
        workers: Number of processes on this machine.
        cluster: Address of a Ray cluster, "auto", or "local" (see `RayRunner`).
        jobs_per_worker: On this machine, start at most one process for so many jobs.
        threads: On this machine, threads of each job.
        gpus: On a cluster, the share of a GPU that each job needs.
    """
    return RayRunner(cluster, gpus) if cluster else LocalRunner(workers, jobs_per_worker, threads)
