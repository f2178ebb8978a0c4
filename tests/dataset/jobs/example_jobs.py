"""Jobs that behave and jobs that do not, importable by workers."""

from __future__ import annotations

import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

from kinmo.core.errors import InputError
from kinmo.dataset.jobs import allow_kill, report


class PanicError(BaseException):
    """An error like that of a Rust core: no Exception."""


def square(number: int) -> int:
    return number * number


def square_or_die(number: int) -> int:
    if number % 7 == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def misbehave(how: str) -> Any:
    if how == "raise":
        raise ValueError("not a number")
    if how == "panic":
        raise PanicError("index out of bounds")
    if how == "exit":
        os._exit(1)
    if how == "return a lock":
        return threading.Lock()
    if how == "raise a KinmoError":
        raise InputError("shape.glb", "expected a mesh")
    if how == "fill the disk":
        Path("/dev/full").write_text("x")
    return how


def threads(number: int) -> set[str | None]:
    return {os.environ.get(name) for name in ("RAYON_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}


def square_and_report(number: int) -> int:
    report(("at", number))
    return number * number


def report_much(number: int) -> int:
    report("x" * 100_000)
    return number


def report_and_die(number: int) -> None:
    report(number)
    if number == 2:
        os.kill(os.getpid(), signal.SIGKILL)


def sleep_if_long(path: Path) -> None:
    allow_kill()
    path.touch()
    time.sleep(300 if path.name == "long" else 0)


def finish_slowly(path: Path) -> None:
    path.with_suffix(".begun").touch()
    time.sleep(0 if path.name == "0" else 1)
    path.with_suffix(".done").touch()


def megabytes_or_die(number: int) -> bytes:
    if number % 7 == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return bytes([number]) * 5_000_000


def die_once(path: Path) -> str:
    """A job with too little memory beside others."""
    if not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path.name


def node() -> str:
    import ray

    return str(ray.get_runtime_context().get_node_id())


def meet(folder: Path) -> str:
    """Wait until jobs run on two nodes at the same time."""
    (folder / node()).touch()
    deadline = time.monotonic() + 60
    while len(list(folder.iterdir())) < 2 and time.monotonic() < deadline:
        time.sleep(0.01)
    return node()


def nap_on_node(number: int) -> str:
    time.sleep(0.3)
    return node()


def torch_threads(number: int) -> int:
    import torch

    return torch.get_num_threads()
