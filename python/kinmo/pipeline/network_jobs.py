"""Runner of jobs that use networks."""

from __future__ import annotations

from kinmo.dataset.jobs import JobRunner, runner_for
from kinmo.learning.weights import ACCELERATOR_PROCESSES, pick_device, processes_on

JOBS_PER_PROCESS = 4
"""Least number of jobs for which another process is started: it imports torch and reads networks first."""


def network_runner(workers: int, device: str, cluster: str | None = None) -> JobRunner:
    """Runner whose processes may have networks on a device. Fewer than `workers` processes share an accelerator."""
    gpus = 0.0 if pick_device(device) == "cpu" else 1.0 / ACCELERATOR_PROCESSES
    return runner_for(processes_on(device, workers), cluster, jobs_per_worker=JOBS_PER_PROCESS, gpus=gpus)
