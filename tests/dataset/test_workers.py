from __future__ import annotations

import errno
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

from kinmo.core.errors import InputError
from kinmo.dataset import workers
from kinmo.dataset.workers import Crashed, map_unordered, may_be_cut_off, or_crashed, tell


def square(number: int) -> int:
    return number * number


def square_or_die(number: int) -> int:
    if number % 7 == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def threads(number: int) -> str:
    return os.environ.get("RAYON_NUM_THREADS", "")


def fail(number: int) -> int:
    raise ValueError("no")


@pytest.mark.parametrize("workers", [1, 2])
def test_every_job_is_answered_once(workers):
    assert sorted(map_unordered(square, iter(range(40)), workers)) == [(n, n * n) for n in range(40)]


def test_a_job_that_kills_its_worker_is_answered_and_the_others_are_done():
    answers = dict(map_unordered(square_or_die, iter(range(12)), 2))
    assert answers == {n: Crashed() if n % 7 == 3 else n * n for n in range(12)}


def test_what_a_job_was_not_built_for_is_its_answer_but_not_what_is_the_users_to_mend():
    def panic(error: BaseException) -> None:
        raise error

    class PanicError(BaseException):
        """As one of a Rust core: no Exception."""

    answer = or_crashed(panic, PanicError("index out of bounds"))
    assert isinstance(answer, Crashed)
    assert re.fullmatch(r"PanicError at test_workers.py:[0-9]+: index out of bounds", answer.why)
    assert or_crashed(square, 3) == 9
    assert isinstance(or_crashed(panic, OSError(errno.EIO, "bad disk")), Crashed)
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    for error in (InputError("shape", "expected more"), full, KeyboardInterrupt(), SystemExit(1)):
        with pytest.raises(type(error)):
            or_crashed(panic, error)


def die_or_name(path: Path) -> str:
    if path.name == "die":
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path.name


def test_a_job_that_comes_when_a_worker_has_just_died_is_done(tmp_path):
    def jobs():
        yield tmp_path / "die"
        while not (tmp_path / "die").exists():
            time.sleep(0.01)
        time.sleep(1.0)  # until the pool knows
        yield tmp_path / "live"

    answers = {path.name: answer for path, answer in map_unordered(die_or_name, jobs(), 2)}
    assert answers == {"die": Crashed(), "live": "live"}


def test_jobs_are_not_taken_long_before_they_are_done():
    taken = []

    def jobs():
        for number in range(200):
            taken.append(number)
            yield number

    for done, _ in enumerate(map_unordered(square, jobs(), 2)):
        assert len(taken) - done < 20


def test_a_worker_uses_one_thread():
    assert {answer for _, answer in map_unordered(threads, range(4), 2)} == {"1"}


def test_what_a_job_raises_reaches_the_caller():
    with pytest.raises(ValueError, match="no"):
        list(map_unordered(fail, range(3), 2))


def square_aloud(number: int) -> int:
    tell(("at", number))
    return number * number


@pytest.mark.parametrize("workers", [1, 2])
def test_what_jobs_tell_is_heard_before_the_last_answer_is_given(workers):
    heard = []
    assert len(list(map_unordered(square_aloud, range(30), workers, heard.append))) == 30
    assert sorted(heard) == [("at", number) for number in range(30)]
    assert square_aloud(3) == 9  # nobody listens
    assert len(heard) == 30


def tell_much(number: int) -> int:
    tell("x" * 100_000)
    return number


def test_a_listener_that_fails_does_not_keep_workers_from_their_work():
    heard = []

    def fail_once(message: str) -> None:
        heard.append(message)
        raise BrokenPipeError("nobody reads")

    with pytest.raises(BrokenPipeError, match="nobody reads"):
        list(map_unordered(tell_much, range(8), 2, fail_once))
    assert len(heard) == 1


def tell_and_die(number: int) -> None:
    tell(number)
    if number == 5:
        os.kill(os.getpid(), signal.SIGKILL)


def test_what_a_worker_told_before_it_died_is_heard():
    heard = []
    assert dict(map_unordered(tell_and_die, range(8), 2, heard.append))[5] == Crashed()
    assert set(heard) == set(range(8))


def sleep_long(path: Path) -> None:
    may_be_cut_off()
    path.touch()
    time.sleep(300 if path.name == "long" else 0)


def test_jobs_that_may_be_cut_off_are_not_waited_for(tmp_path):
    answers = map_unordered(sleep_long, [tmp_path / "long", tmp_path / "short"], 2)
    assert next(answers)[0].name == "short"
    started = time.monotonic()
    answers.close()
    assert time.monotonic() - started < 200


@pytest.mark.parametrize("is_running", [True, False])
def test_a_worker_is_cut_off_only_within_a_job_and_not_with_the_queue_in_its_hands(monkeypatch, is_running):
    ended = []
    monkeypatch.setattr(workers.os, "_exit", ended.append)
    stopped, stop = multiprocessing.Pipe(duplex=False)
    stop.close()
    workers._cut_off(stopped, workers._RunningJob(is_running))
    assert ended == ([1] if is_running else [])


def note_the_job(number: int) -> bool:
    return workers._job is not None and workers._job.is_running


def test_a_job_is_running_while_it_runs(monkeypatch):
    monkeypatch.setattr(workers, "_job", None)
    assert all(answer is True for _, answer in map_unordered(note_the_job, range(4), 2))
    assert workers._unless_stopped(note_the_job, 0)
    assert workers._job is not None
    assert not workers._job.is_running


def wait_for_release(job: tuple[Path, int]) -> None:
    folder, number = job
    (folder / f"{number}.started").touch()
    while number and not (folder / "released").exists():
        time.sleep(0.01)


def test_jobs_that_wait_in_the_queue_are_dropped_when_the_work_is_stopped(tmp_path, monkeypatch):
    shutdown = ProcessPoolExecutor.shutdown

    def release(*arguments, **options):
        (tmp_path / "released").touch()
        shutdown(*arguments, **options)

    monkeypatch.setattr(ProcessPoolExecutor, "shutdown", release)
    answers = map_unordered(wait_for_release, ((tmp_path, number) for number in range(20)), 2)
    next(answers)
    answers.close()
    assert len(list(tmp_path.glob("*.started"))) <= 3  # the one that was answered, and those that the two workers were at


def test_workers_end_with_a_process_that_is_killed(tmp_path):
    script = tmp_path / "owner.py"
    script.write_text(
        "import os, sys, time\n"
        "from kinmo.dataset.workers import map_unordered\n"
        "def job(number):\n"
        "    open(os.path.join(os.path.dirname(__file__), f'{os.getpid()}.pid'), 'w').close()\n"
        "    time.sleep(60)\n"
        "if __name__ == '__main__':\n"
        "    list(map_unordered(job, range(2), 2))\n"
    )
    owner = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while len(pids := [int(path.stem) for path in tmp_path.glob("*.pid")]) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    owner.kill()
    owner.wait()
    while any(is_running(pid) for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(pids) == 2
    assert not any(is_running(pid) for pid in pids)


def test_nobody_but_the_owner_minds_an_interrupt_while_workers_start(tmp_path):
    script = tmp_path / "owner.py"
    script.write_text(
        "import os, signal, threading, time\n"
        "from kinmo.dataset.workers import map_unordered\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever started the tests may ignore it\n"
        "    threading.Timer(0.1, os.killpg, (0, signal.SIGINT)).start()\n"
        "    list(map_unordered(time.sleep, [0.5] * 8, 2))\n"
    )
    owner = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, start_new_session=True, timeout=60)
    assert owner.returncode != 0
    assert owner.stderr.count("Traceback") == 1 and owner.stderr.rstrip().endswith("KeyboardInterrupt")


def is_running(pid: int) -> bool:
    """Whether a process is there and is not merely waiting to be buried."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"
