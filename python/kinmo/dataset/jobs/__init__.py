"""One job runner with two backends: processes of this machine, and a Ray cluster."""

from kinmo.dataset.jobs.backends import runner_for
from kinmo.dataset.jobs.cluster import RayRunner
from kinmo.dataset.jobs.local import LocalRunner
from kinmo.dataset.jobs.runner import Failure, JobRunner
from kinmo.dataset.jobs.worker import allow_kill, report

__all__ = ["Failure", "JobRunner", "LocalRunner", "RayRunner", "allow_kill", "report", "runner_for"]
