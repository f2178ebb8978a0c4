"""Jobs on a Ray cluster.

All nodes must see the same files under the same paths (a shared file system) and have the same version of kinmo.
"""

from __future__ import annotations

import os
import platform
import signal
import socket
import threading
from collections.abc import Callable, Generator, Iterable
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from typing import Any

from kinmo._core import __version__
from kinmo.core.errors import InputError, KinmoError
from kinmo.dataset.jobs.runner import THREAD_VARIABLES, Failure, Job, Owner, Result, attempt, owned_by

ATTEMPTS = 3
"""Runs of a job whose process or node dies."""
JOBS_PER_SLOT = 2
"""Jobs in flight for each one that can run."""
MESSAGE_SECONDS = 0.5
"""Time between two looks for messages."""
CONNECT_SECONDS = 10


@dataclass(frozen=True)
class RayRunner:
    """Runs jobs on a Ray cluster, one per CPU. Nodes may join and leave during a run.

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
        box = None if on_message is None else _message_box(ray)
        task = ray.remote(max_retries=0, num_gpus=self.gpus)(_task())
        submit = partial(task.remote, [ray.put(function)], __version__, box)
        remaining = ((job, 1) for job in jobs)
        again: list[tuple[Job, int]] = []
        in_flight: dict[Any, tuple[Job, int]] = {}
        try:
            while True:
                have = ray.cluster_resources()
                slots = have.get("GPU", 0) / self.gpus if self.gpus else have.get("CPU", 0)
                free = max(JOBS_PER_SLOT * int(slots), 1) - len(in_flight)
                while free > 0 and (next_one := again.pop() if again else next(remaining, None)):
                    in_flight[submit(ray.cloudpickle.dumps(next_one[0]))] = next_one
                    free -= 1
                if not in_flight:
                    break
                refs = list(in_flight)
                ray.wait(refs, timeout=MESSAGE_SECONDS if box is not None else None)
                ready, _ = ray.wait(refs, num_returns=len(refs), timeout=0)
                if box is not None and on_message is not None:
                    for message in box.get_nowait_batch(box.qsize()):
                        on_message(message)
                for ref in ready:
                    job, attempts = in_flight.pop(ref)
                    try:
                        error, result = ray.get(ref)
                    except ray.exceptions.RayTaskError as problem:  # job or result cannot be pickled
                        error, result = None, Failure(str(problem).strip().splitlines()[-1])
                    except ray.exceptions.RayError as problem:
                        if attempts < ATTEMPTS:
                            again.append((job, attempts + 1))
                            continue
                        error, result = None, Failure(f"its process died {ATTEMPTS} times ({type(problem).__name__})")
                    if error is not None:
                        raise KinmoError(self.address, error) if isinstance(error, str) else error
                    yield job, result
        finally:
            _end(ray, list(in_flight))


def _connected(address: str) -> Any:
    """Ray, connected to the cluster."""
    try:
        ray = import_module("ray")
    except ImportError:
        raise InputError(address, "Ray is not installed. Install it: pip install 'kinmo[cluster]'") from None
    if ray.is_initialized():
        return ray
    host, _, port = address.removeprefix("ray://").rpartition(":")
    options = {"include_dashboard": False} if address == "local" else {}
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        if port.isdigit():  # without a server there, Ray would try for a minute and end this process
            socket.create_connection((host, int(port)), CONNECT_SECONDS).close()
        ray.init(address, logging_level="WARNING", log_to_driver=False, **options)
    except (OSError, RuntimeError, ValueError) as error:
        problem = (str(error).splitlines() or [type(error).__name__])[0].rstrip(".")
        remedy = "Start one with `ray start --head`, and run kinmo on one of its machines with --cluster auto"
        raise InputError(address, f"cannot connect to a Ray cluster ({problem}). {remedy}") from error
    ray._private.worker._worker_logs_enabled = False  # else it prints about dead workers on stdout
    return ray


def _message_box(ray: Any) -> Any:
    """Queue on the owner's node: other nodes may leave."""
    here = ray.get_runtime_context().get_node_id()
    strategy = import_module("ray.util.scheduling_strategies").NodeAffinitySchedulingStrategy(here, soft=True)
    return import_module("ray.util.queue").Queue(actor_options={"num_cpus": 0, "scheduling_strategy": strategy})


def _end(ray: Any, refs: list[Any]) -> None:
    """Drop what waits, and wait for what runs. A second Ctrl-C kills it."""
    try:
        for ref in refs:
            ray.cancel(ref)
        if refs:
            ray.wait(refs, num_returns=len(refs))
    except BaseException:
        for ref in refs:
            ray.cancel(ref, force=True)
        raise


def _task() -> Callable[..., tuple[BaseException | str | None, Any]]:
    """`perform`, as a function that Ray sends as code: a node may have no kinmo."""

    def run_job(*arguments: Any) -> tuple[BaseException | str | None, Any]:
        try:
            from kinmo.dataset.jobs.cluster import perform
        except ImportError as error:
            return f"a node cannot import kinmo ({error}). Install it on all nodes", None
        return perform(*arguments)

    return run_job


def perform(function: list[Any], version: str, box: Any, job: bytes) -> tuple[BaseException | str | None, Any]:
    """Run a pickled job in a Ray worker. Returns what ends the run, or None, and the result."""
    if version != __version__:
        return f"{platform.node()} has kinmo {__version__}, expected {version}. Install {version} on all nodes", None
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # with which Ray cancels
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    loads = import_module("ray").cloudpickle.loads
    try:
        with owned_by(Owner(Owner().report if box is None else box.put, _allow_kill)):
            return None, attempt(lambda data: _loaded(function[0])(loads(data)), job)
    except BaseException as error:
        return error, None


@lru_cache(maxsize=1)
def _loaded(function: Any) -> Callable[[Any], Any]:
    """The function of a run. A worker loads it once."""
    loaded: Callable[[Any], Any] = import_module("ray").get(function)
    return loaded


def _allow_kill() -> None:
    """End the process at once when Ray cancels the job, also in a library, where no handler of Python runs."""
    signal.signal(signal.SIGINT, lambda number, frame: None)
    _exit_on_signal()


@lru_cache(maxsize=1)
def _exit_on_signal() -> None:
    heard, said = socket.socketpair()
    said.setblocking(False)
    signal.set_wakeup_fd(said.fileno())
    threading.Thread(target=lambda: (heard.recv(1), os._exit(1), said), daemon=True).start()
