"""Jobs on processes of this machine.

Each worker has its own pipe and one job at a time. Workers share no lock and no queue. Thus a worker may die at any moment: the
owner reads the end of its pipe and knows its job.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator, Iterable, Iterator, Sized
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from multiprocessing import connection, resource_tracker
from multiprocessing.reduction import ForkingPickler
from typing import Any, Generic, Literal

from kinmo.dataset.jobs.runner import THREAD_VARIABLES, Failure, Job, Owner, Result, attempt, owned_by

LOST = Failure("its process died (too little memory?)")
Kind = Literal["ready", "message", "allows kill", "result", "error"]
"""Kinds of what a worker sends."""


@dataclass(frozen=True)
class LocalRunner:
    """Runs jobs on this machine.

    Results do not depend on the number of workers. A job whose process dies runs once more at the end, alone: other jobs may
    have taken the memory. Workers end with this process, however it ends.

    Args:
        workers: Number of processes. With 1 or less, jobs run in this process, in order.
        jobs_per_worker: Start at most one process for so many jobs, if `jobs` has a length. 0 sets no limit.
        threads: Threads of each job. 0 leaves them to its libraries. In this process it applies to torch, if that is imported.
    """

    workers: int
    jobs_per_worker: int = 0
    threads: int = 1

    def run(
        self, function: Callable[[Job], Result], jobs: Iterable[Job], on_message: Callable[[Any], None] | None = None
    ) -> Generator[tuple[Job, Result | Failure], None, None]:
        """Run `function` over all jobs (`JobRunner.run`)."""
        workers, hear = self.workers, on_message or Owner().report
        if self.jobs_per_worker and isinstance(jobs, Sized):
            workers = min(workers, len(jobs) // self.jobs_per_worker)
        if workers <= 1:
            for job in jobs:
                with owned_by(Owner(hear)), _torch_threads(self.threads):
                    result = attempt(function, job)
                yield job, result
            return
        lost: list[Job] = []
        with closing(_on_processes(function, jobs, workers, self.threads, hear)) as results:
            for job, result in results:
                if result is LOST:
                    lost.append(job)
                else:
                    yield job, result
        with closing(_on_processes(function, lost, 1, self.threads, hear)) as results:
            yield from results


class _Worker(Generic[Job, Result]):
    """A process, the pipe to it, and its last job."""

    job: Job
    is_ready = False
    is_busy = False
    may_be_killed = False

    def __init__(self, function: Callable[[Job], Result], threads: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, far_end = context.Pipe()
        self.process = context.Process(target=_serve, args=(function, far_end), daemon=True)
        # another thread starts the process, so that an interrupt cannot cut the start short
        starter = ThreadPoolExecutor(1, initializer=_block_interrupts)
        with far_end, _thread_variables(threads), _without_main_script(function), starter:
            starter.submit(self.process.start).result()

    def begin(self, job: Job) -> None:
        self.job, self.is_busy, self.may_be_killed = job, True, True  # an interrupt here leaves half a job in the pipe
        with suppress(OSError):  # it is dead, as `receive` finds
            self.pipe.send(job)
        self.may_be_killed = False

    def receive(self) -> tuple[Kind, Any]:
        """Next message of the worker; the result `LOST` if it is dead."""
        may_be_killed, self.may_be_killed = self.may_be_killed, True  # an interrupt here leaves half a message in the pipe
        kind: Kind
        try:
            kind, value = self.pipe.recv()
        except (EOFError, OSError):
            kind, value = "result", LOST
        self.is_ready |= kind == "ready"
        self.is_busy &= kind not in ("result", "error")
        self.may_be_killed = may_be_killed or kind == "allows kill"
        return kind, value

    def end_if_allowed(self) -> bool:
        """Kill the worker if its job allows that."""
        if self.may_be_killed:
            self.process.kill()
            self.is_busy = False
        return self.may_be_killed


def _on_processes(
    function: Callable[[Job], Result], jobs: Iterable[Job], workers: int, threads: int, hear: Callable[[Any], None]
) -> Generator[tuple[Job, Result | Failure], None, None]:
    """Each job with its result; `LOST` if its process died."""
    remaining = iter(jobs)
    idle: list[_Worker[Job, Result]] = []
    busy: list[_Worker[Job, Result]] = []
    done: list[tuple[Job, Result | Failure]] = []
    try:
        while True:
            for job in islice(remaining, workers - len(busy)):
                busy.append(idle.pop() if idle else _Worker(function, threads))
                busy[-1].begin(job)
            yield from done
            if not busy:
                break
            done = []
            for worker in _with_news(busy):
                kind, value = worker.receive()
                if kind == "message":
                    hear(value)
                if worker.is_busy:
                    continue
                if value is LOST and not any(each.is_ready for each in [*idle, *busy]):
                    raise ChildProcessError("No worker could start. See its message above.")
                busy.remove(worker)
                if value is LOST:
                    _end([worker])
                else:
                    idle.append(worker)
                if kind == "error":
                    raise value
                done.append((worker.job, value))
    finally:
        _end([*idle, *busy])


def _with_news(workers: list[_Worker[Job, Result]]) -> list[_Worker[Job, Result]]:
    """Workers that have sent something or died. Waits for the first."""
    pipes = connection.wait([each.pipe for each in workers])
    return [each for each in workers if each.pipe in pipes]


def _end(workers: list[_Worker[Job, Result]]) -> None:
    """End workers after their job, or at once if that allows it. A second Ctrl-C kills all."""
    try:
        while busy := [each for each in workers if each.is_busy and not each.end_if_allowed()]:
            for worker in _with_news(busy):
                worker.receive()
        for worker in workers:
            worker.pipe.close()
        for worker in workers:
            worker.process.join()
    except BaseException:
        for worker in workers:
            worker.process.kill()
        raise


def _serve(function: Callable[[Job], Result], pipe: connection.Connection) -> None:
    """Body of a worker. It ends when the owner closes the pipe, and at once when the owner dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_owner, daemon=True).start()

    def send(kind: Kind, value: Any = None) -> None:
        pipe.send((kind, value))

    def pickled_result(job: Job) -> Any:
        return ForkingPickler.dumps(("result", function(job)))

    owner = Owner(lambda message: send("message", message), lambda: send("allows kill"))
    with suppress(EOFError, BrokenPipeError), owned_by(owner):
        send("ready")
        while True:
            job = pipe.recv()
            try:
                result = attempt(pickled_result, job)
            except BaseException as error:
                send("error", error)
            else:
                send("result", result) if isinstance(result, Failure) else pipe.send_bytes(result)


def _end_with_owner() -> None:
    owner = multiprocessing.parent_process()
    if owner is not None:
        connection.wait([owner.sentinel])
        os._exit(1)


def _block_interrupts() -> None:
    """Processes that this thread starts never see Ctrl-C."""
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # starts with the first process, and would unblock them
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


@contextmanager
def _without_main_script(function: Callable[..., Any]) -> Iterator[None]:
    """Processes that start in the block do not import the main script, unless the function comes from there.

    A script without `if __name__ == "__main__":` would otherwise run again in every worker.
    """
    main = sys.modules["__main__"]
    is_needed = b"__main__" in bytes(ForkingPickler.dumps(function))
    hidden = {} if is_needed else {name: getattr(main, name) for name in ("__spec__", "__file__") if hasattr(main, name)}
    try:
        vars(main).update(dict.fromkeys(hidden))
        yield
    finally:
        vars(main).update(hidden)


@contextmanager
def _thread_variables(threads: int) -> Iterator[None]:
    """Processes that start in the block use so many threads. The environment tells them before they import anything."""
    before = {name: os.environ.get(name) for name in THREAD_VARIABLES}
    try:
        if threads:
            os.environ.update(dict.fromkeys(before, str(threads)))
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name, None) if value is None else os.environ.update({name: value})


@contextmanager
def _torch_threads(threads: int) -> Iterator[None]:
    """Torch uses so many threads in the block, if this process has imported it."""
    torch = sys.modules.get("torch")
    if torch is None or not threads:
        yield
        return
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    try:
        yield
    finally:
        torch.set_num_threads(before)
