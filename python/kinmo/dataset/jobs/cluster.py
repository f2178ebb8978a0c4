"""Jobs on a Ray cluster.

All nodes must see the same files under the same paths (a shared file system) and have the same version of kinmo.
"""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from itertools import chain, islice
from typing import Any

from kinmo import __version__
from kinmo.core.errors import InputError, KinmoError
from kinmo.dataset.jobs.runner import Failure, Job, Result
from kinmo.dataset.jobs.worker import THREAD_VARIABLES, Owner, attempt, owned_by

MOST_ATTEMPTS = 3
"""A job that has lost so many processes or nodes has failed."""
JOBS_PER_SLOT = 2
"""Jobs in flight for each that can run at the same time."""
SECONDS_BETWEEN_MESSAGES = 0.5
CONNECT_SECONDS = 10


@dataclass(frozen=True)
class RayRunner:
    """Runs jobs on a Ray cluster, one per CPU, or on the GPUs. Nodes may join and leave in the middle of a run.

    A job whose process or node dies runs again, at most three times in all.

    Args:
        address: "auto" or "HOST:PORT": the running cluster that this machine belongs to. "local": start Ray on this machine.
            A process that is connected to Ray already stays with that cluster.
        gpus: Share of a GPU that each job needs.
    """

    address: str
    gpus: float = 0.0

    def run(
        self, function: Callable[[Job], Result], jobs: Iterable[Job], on_message: Callable[[Any], None] | None = None
    ) -> Generator[tuple[Job, Result | Failure], None, None]:
        """Run `function` over all jobs (`JobRunner.run`).

        Raises:
            InputError: Ray is not installed, the cluster cannot be reached, or it has no GPU for jobs that need one.
            KinmoError: A node has no kinmo, or another version.
        """
        ray = _connected(self.address)
        if self.gpus and not ray.cluster_resources().get("GPU"):
            raise InputError(self.address, "the cluster has no GPU. Use --device cpu, or add a node with a GPU")
        task = ray.remote(max_retries=0, num_gpus=self.gpus)(_task())
        submit = partial(task.remote, [ray.put(function)], __version__)
        box = None if on_message is None else _message_box(ray)
        remaining = ((job, 1) for job in jobs)
        again: list[tuple[Job, int]] = []
        in_flight: dict[Any, tuple[Job, int]] = {}
        try:
            while True:
                for job, attempts in islice(chain(_taken(again), remaining), self._most_in_flight(ray) - len(in_flight)):
                    in_flight[submit(ray.cloudpickle.dumps(job), box)] = job, attempts
                if not in_flight:
                    break
                refs = list(in_flight)
                ray.wait(refs, timeout=None if box is None else SECONDS_BETWEEN_MESSAGES)
                ready, _ = ray.wait(refs, num_returns=len(refs), timeout=0)
                _deliver(box, on_message)
                for ref in ready:
                    job, attempts = in_flight.pop(ref)
                    try:
                        error, result = ray.get(ref)
                    except ray.exceptions.RayTaskError as problem:
                        error, result = None, Failure(str(problem).strip().splitlines()[-1])
                    except ray.exceptions.RayError as problem:
                        if attempts < MOST_ATTEMPTS:
                            again.append((job, attempts + 1))
                            continue
                        error, result = None, Failure(f"its process died {attempts} times ({type(problem).__name__})")
                    if error is not None:
                        raise KinmoError(self.address, error) if isinstance(error, str) else error
                    yield job, result
        finally:
            _cancel(ray, list(in_flight))

    def _most_in_flight(self, ray: Any) -> int:
        have = ray.cluster_resources()
        slots = min(have.get("CPU", 1), have.get("GPU", 0) / self.gpus) if self.gpus else have.get("CPU", 1)
        return max(JOBS_PER_SLOT * int(slots), 1)


def perform(function: list[Any], version: str, job: bytes, box: Any) -> tuple[BaseException | str | None, Any]:
    """Run one job, in a Ray worker.

    Args:
        function: The reference to the function.
        version: Version of kinmo that the owner has.
        job: The pickled job.
        box: Queue for messages.

    Returns:
        What ends the run, or None; and the result.
    """
    if version != __version__:
        return f"{os.uname().nodename} has kinmo {__version__}, expected {version}. Install {version} on all nodes", None
    ray = import_module("ray")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ray cancels by SIGINT
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    owner = Owner(box.put if box else Owner().report, _allow_cancel)
    try:
        with owned_by(owner):
            return None, attempt(lambda data: _loaded(function[0])(ray.cloudpickle.loads(data)), job)
    except BaseException as error:
        return error, None


def _allow_cancel() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@lru_cache(maxsize=1)
def _loaded(function: Any) -> Callable[[Any], Any]:
    """The function of a run. A worker loads it once."""
    loaded: Callable[[Any], Any] = import_module("ray").get(function)
    return loaded


def _task() -> Callable[..., tuple[Any, Any]]:
    """`perform` for nodes that may have no kinmo. Ray sends an inner function as code."""

    def run_job(*arguments: Any) -> tuple[Any, Any]:
        try:
            from kinmo.dataset.jobs.cluster import perform
        except ImportError as error:
            return f"a node cannot import kinmo ({error}). Install it on all nodes", None
        return perform(*arguments)

    return run_job


def _connected(address: str) -> Any:
    """Ray, connected to the cluster."""
    try:
        ray = import_module("ray")
    except ImportError:
        raise InputError(address, "Ray is not installed. Install it: pip install 'kinmo[cluster]'") from None
    if not ray.is_initialized():
        host, _, port = address.removeprefix("ray://").rpartition(":")
        options = {"include_dashboard": False} if address == "local" else {}
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        try:
            if port.isdigit():  # Ray tries for minutes and then ends the process
                socket.create_connection((host, int(port)), CONNECT_SECONDS).close()
            ray.init(address, logging_level="WARNING", log_to_driver=False, **options)
        except (OSError, RuntimeError, ValueError) as error:
            problem = (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
            remedy = "Start one with `ray start --head`, and run kinmo on one of its machines with --cluster auto"
            raise InputError(address, f"cannot connect to a Ray cluster ({problem}). {remedy}") from error
    return ray


def _message_box(ray: Any) -> Any:
    """Queue on the owner's node, which outlives the other nodes."""
    strategies = import_module("ray.util.scheduling_strategies")
    here = strategies.NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=True)
    return import_module("ray.util.queue").Queue(actor_options={"num_cpus": 0, "scheduling_strategy": here})


def _deliver(box: Any, on_message: Callable[[Any], None] | None) -> None:
    if box is not None and on_message is not None:
        for message in box.get_nowait_batch(box.qsize()):
            on_message(message)


def _taken(again: list[tuple[Job, int]]) -> Iterator[tuple[Job, int]]:
    while again:
        yield again.pop()


def _cancel(ray: Any, refs: list[Any]) -> None:
    """Drop what waits, and wait for what runs. A second Ctrl-C kills it."""
    try:
        for ref in refs:
            ray.cancel(ref)
        ray.wait(refs, num_returns=len(refs)) if refs else None
    except BaseException:
        for ref in refs:
            ray.cancel(ref, force=True)
        raise
