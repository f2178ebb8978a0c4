"""A pool of processes that outlives what its work does to it, and does not outlive its owner."""

from __future__ import annotations

import errno
import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing import connection
from multiprocessing.context import SpawnContext
from multiprocessing.synchronize import Lock
from pathlib import Path
from types import FrameType
from typing import Any, TypeVar

from kinmo.core.errors import KinmoError

Job = TypeVar("Job")
Answer = TypeVar("Answer")
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""Of a system's errors: nothing can be written any more."""
_QUEUED_PER_WORKER = 4


@dataclass(frozen=True)
class Crashed:
    """The answer to a job that nobody foresaw the failure of, and `why` it failed."""

    why: str = "its process died (too little memory?)"


def or_crashed(function: Callable[[Job], Answer], job: Job) -> Answer | Crashed:
    """`function` of a job, or `Crashed`: for whatever else it raises than a KinmoError and what ends the program.

    A panic of the Rust core counts too; it is no Exception. A full disk does not: the next job would fill it no less.
    """
    try:
        return function(job)
    except (KinmoError, KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:
        if isinstance(error, OSError) and error.errno in FULL:
            raise
        where = traceback.extract_tb(error.__traceback__)[-1]
        return Crashed(f"{type(error).__name__} at {Path(where.filename).name}:{where.lineno}: {error}")


def map_unordered(
    function: Callable[[Job], Answer],
    jobs: Iterable[Job],
    workers: int,
    on_message: Callable[[Any], None] | None = None,
) -> Iterator[tuple[Job, Answer | Crashed]]:
    """`function` of every job, as the answers come; with one worker in this process, in order.

    Only a few jobs a worker are taken from `jobs` ahead of time, so memory does not grow with their number. `function` must be
    importable by name. If a worker dies, the jobs in flight are done again one at a time, and the one that kills it is answered
    with `Crashed`. Workers use one thread each and end with this process, however that ends. `on_message` is given what jobs
    `tell`, on a thread of its own where there are several workers.
    """
    global _messages
    if workers <= 1:
        outer, _messages = _messages, on_message
        try:
            for job in jobs:
                yield job, function(job)
        finally:
            _messages = outer
        return
    remaining = iter(jobs)
    suspects: list[Job] = []
    finished = False
    while suspects or not finished:
        if suspects:
            yield from _one_at_a_time(function, suspects, on_message)
            suspects = []
        else:
            in_flight: dict[Future[Answer], Job] = {}
            with _pool(workers, on_message) as pool:
                try:
                    while True:
                        for job in islice(remaining, _QUEUED_PER_WORKER * workers - len(in_flight)):
                            suspects = [job]  # of a pool that has just been broken, which does not take it
                            with _interrupts_held():
                                in_flight[pool.submit(_unless_stopped, function, job)] = job
                            suspects = []
                        if not in_flight:
                            finished = True
                            break
                        for future in wait(in_flight, return_when=FIRST_COMPLETED).done:
                            answer = future.result()
                            yield in_flight.pop(future), answer
                except BrokenProcessPool:
                    suspects += in_flight.values()


def tell(message: Any) -> None:
    """Of a job: hand `message`, which must be fit to be pickled, to whoever called `map_unordered`."""
    if _messages is not None:
        _messages(message)


def may_be_cut_off() -> None:
    """Of a job: when its pool is stopped, this worker is to end at once, and not when the job is done."""
    if _stopped is not None and _job is not None:
        threading.Thread(target=_cut_off, args=(_stopped, _job), daemon=True).start()


def _cut_off(stopped: connection.Connection, job: _RunningJob) -> None:
    """End the worker when the pool is stopped, if the job still runs.

    A worker between two jobs may hold the lock of the queue of all, which would be held for ever then.
    """
    connection.wait([stopped])
    with job.turn:
        if job.is_running:
            os._exit(1)


def _one_at_a_time(
    function: Callable[[Job], Answer], jobs: list[Job], on_message: Callable[[Any], None] | None
) -> Iterator[tuple[Job, Answer | Crashed]]:
    pending = list(jobs)
    while pending:
        with _pool(1, on_message) as pool:
            while pending:
                job = pending.pop(0)
                try:
                    with _interrupts_held():
                        future = pool.submit(_unless_stopped, function, job)
                    answer: Answer | Crashed = future.result()
                except BrokenProcessPool:
                    answer = Crashed()
                yield job, answer
                if isinstance(answer, Crashed):
                    break


@contextmanager
def _pool(workers: int, on_message: Callable[[Any], None] | None) -> Iterator[ProcessPoolExecutor]:
    """A pool that waits, when an exception ends its use, for the jobs at work, but not for those that stand in its queue."""
    context = multiprocessing.get_context("spawn")
    stopped, stop = context.Pipe(duplex=False)
    with (
        _heard(on_message, context) as voice,
        stopped,
        stop,
        ProcessPoolExecutor(workers, context, initializer=_start_worker, initargs=(stopped, voice)) as pool,
    ):
        try:
            yield pool
        except BaseException:
            stop.close()
            pool.shutdown(cancel_futures=True)
            raise


@dataclass(frozen=True)
class _Voice:
    """Where workers speak, one at a time."""

    end: connection.Connection
    turn: Lock

    def __call__(self, message: Any) -> None:
        with self.turn:
            self.end.send(message)


@contextmanager
def _heard(on_message: Callable[[Any], None] | None, context: SpawnContext) -> Iterator[_Voice | None]:
    """What is said reaches `on_message`, all of it by the end of the block, when the workers must have ended."""
    if on_message is None:
        yield None
        return
    heard, said = context.Pipe(duplex=False)
    errors: list[BaseException] = []
    ear = threading.Thread(target=_listen, args=(heard, on_message, errors), daemon=True)
    ear.start()
    try:
        yield _Voice(said, context.Lock())
    finally:
        said.close()
        ear.join()
        heard.close()
    if errors:
        raise errors[0]


def _listen(heard: connection.Connection, on_message: Callable[[Any], None], errors: list[BaseException]) -> None:
    """Until nobody is left who could say something. Whatever `on_message` raises ends its calls, but workers can speak on."""
    with suppress(EOFError):
        while True:
            message = heard.recv()
            if not errors:
                try:
                    on_message(message)
                except BaseException as error:
                    errors.append(error)


_messages: Callable[[Any], None] | None = None
"""Where a job's messages go."""
_stopped: connection.Connection | None = None
"""Of a worker: has something to read, the end, once its pool is stopped."""


@dataclass
class _RunningJob:
    """What a worker is at; `turn` keeps it from ending within what is done with the rest."""

    is_running: bool = True
    turn: threading.Lock = field(default_factory=threading.Lock)


_job: _RunningJob | None = None
"""Of a worker: the job that it is at."""


def _unless_stopped(function: Callable[[Job], Answer], job: Job) -> Answer:
    global _job
    if _stopped is not None and _stopped.poll():
        raise CancelledError
    _job = _RunningJob()
    try:
        return function(job)
    finally:
        with _job.turn:
            _job.is_running = False


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Ctrl-C waits until the block is over. Processes that start in it never see one, not even before `_start_worker`.

    They inherit the mask; the handler is for interrupts that reach another thread of this process.
    """
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    came: list[tuple[int, FrameType | None]] = []
    handler = signal.signal(signal.SIGINT, lambda number, frame: came.append((number, frame)))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, handler)
        if came and callable(handler):
            handler(*came[0])


def _start_worker(stopped: connection.Connection, voice: _Voice | None) -> None:
    """One thread a worker; Ctrl-C is left to the owner, with which the worker ends."""
    global _stopped, _messages
    _stopped, _messages = stopped, voice
    os.environ |= dict.fromkeys(("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    owner = multiprocessing.parent_process()
    if owner is not None:
        threading.Thread(target=_end_with, args=(owner.sentinel,), daemon=True).start()


def _end_with(sentinel: int | connection.Connection) -> None:
    connection.wait([sentinel])
    os._exit(1)
