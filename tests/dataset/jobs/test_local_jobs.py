"""Processes of this machine: how they end, and what they survive."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from tests.dataset.jobs import example_jobs as jobs

from kinmo.dataset.jobs import Failure, LocalRunner
from kinmo.dataset.jobs.local import LOST

OWNER = """
import os, signal, sys, threading, time
from pathlib import Path
from kinmo.dataset.jobs import LocalRunner
def job(number):
    (Path(__file__).parent / f"{os.getpid()}.pid").touch()
    time.sleep(60)
def nap(seconds):
    time.sleep(seconds)
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # the parent may ignore it
"""


def start_owner(folder: Path, body: str) -> subprocess.Popen[str]:
    script = folder / "owner.py"
    script.write_text(OWNER + "".join(f"    {line}\n" for line in body.splitlines()))
    return subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True, start_new_session=True)


def worker_pids(folder: Path) -> list[int]:
    """The processes of two workers that are at a job."""
    deadline = time.monotonic() + 60
    while len(pids := [int(path.stem) for path in folder.glob("*.pid")]) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    assert len(pids) == 2
    return pids


def all_end(pids: list[int]) -> bool:
    deadline = time.monotonic() + 30
    while any(is_running(pid) for pid in pids) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not any(is_running(pid) for pid in pids)


def is_running(pid: int) -> bool:
    """True if a process exists and is no zombie."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def test_one_worker_runs_jobs_in_this_process_in_order() -> None:
    heard = []
    pids = LocalRunner(1).run(lambda number: (number, os.getpid()), range(5))
    assert [result for _, result in pids] == [(number, os.getpid()) for number in range(5)]
    assert isinstance(dict(LocalRunner(1).run(jobs.misbehave, ["raise"]))["raise"], Failure)
    assert len(list(LocalRunner(1).run(jobs.square_and_report, range(3), heard.append))) == len(heard) == 3


def test_few_jobs_start_no_process() -> None:
    (pid,) = {result for _, result in LocalRunner(2, jobs_per_worker=4).run(lambda number: os.getpid(), range(7))}
    assert pid == os.getpid()


def test_torch_uses_one_thread_in_this_process_too(monkeypatch: pytest.MonkeyPatch) -> None:
    count = [8]
    torch = SimpleNamespace(get_num_threads=lambda: count[0], set_num_threads=lambda threads: count.__setitem__(0, threads))
    monkeypatch.setitem(sys.modules, "torch", torch)
    for threads, used in ((1, 1), (3, 3), (0, 8)):
        for _, result in LocalRunner(1, threads=threads).run(jobs.torch_threads, range(2)):
            assert (result, torch.get_num_threads()) == (used, 8)


def test_jobs_need_no_torch() -> None:
    script = "import sys, kinmo.dataset.jobs as jobs; list(jobs.LocalRunner(1).run(abs, [1]))"
    script += "; print({'torch', 'ray'} & {*sys.modules})"
    assert subprocess.check_output([sys.executable, "-c", script], text=True).strip() == "set()"


def test_large_results_survive_workers_that_die() -> None:
    results = dict(LocalRunner(2).run(jobs.megabytes_or_die, range(24)))
    assert {n for n, result in results.items() if result == LOST} == {n for n in range(24) if n % 7 == 3}
    assert all(result == bytes([n]) * 5_000_000 for n, result in results.items() if n % 7 != 3)


def test_large_jobs_do_not_block_large_results() -> None:
    data = [bytes([number]) * 3_000_000 for number in range(8)]
    assert sorted(result for _, result in LocalRunner(2).run(bytes, data)) == data


def test_a_worker_that_dies_between_two_jobs_loses_none() -> None:
    pids = LocalRunner(2).run(_own_pid, range(6))
    first = next(pids)
    time.sleep(1)  # both are idle
    os.kill(first[1], signal.SIGKILL)
    rest = [result for _, result in pids]
    assert len(rest) == 5 and not any(isinstance(each, Failure) for each in rest)


def _own_pid(number: int) -> int:
    return os.getpid()


def test_workers_that_cannot_start_end_the_run(tmp_path: Path) -> None:
    script = tmp_path / "unguarded.py"
    body = "def job(number):\n    return number\nlist(LocalRunner(2).run(job, range(9)))\n"
    script.write_text(f"from kinmo.dataset.jobs import LocalRunner\n{body}")
    owner = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60)
    assert owner.stderr.rstrip().endswith("ChildProcessError: No worker could start. See its message above.")


def test_workers_do_not_run_a_script_that_they_do_not_need(tmp_path: Path) -> None:
    script = tmp_path / "unguarded.py"
    script.write_text("from kinmo.dataset.jobs import LocalRunner\nprint([r for _, r in LocalRunner(2).run(abs, [-1, -1])])\n")
    owner = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=True)
    assert owner.stdout == "[1, 1]\n" and not owner.stderr


def test_workers_end_with_an_owner_that_is_killed(tmp_path: Path) -> None:
    owner = start_owner(tmp_path, "list(LocalRunner(2).run(job, range(2)))")
    pids = worker_pids(tmp_path)
    owner.kill()
    owner.communicate()
    assert all_end(pids)


def test_a_second_interrupt_kills_running_jobs(tmp_path: Path) -> None:
    owner = start_owner(tmp_path, "list(LocalRunner(2).run(job, range(9)))")
    pids = worker_pids(tmp_path)
    owner.send_signal(signal.SIGINT)
    time.sleep(1)
    assert all(is_running(pid) for pid in pids), "the first one lets them finish"
    owner.send_signal(signal.SIGINT)
    assert owner.communicate(timeout=30)[1].rstrip().endswith("KeyboardInterrupt")
    assert all_end(pids)


@pytest.mark.parametrize("seconds", [0.0, 0.05, 0.2])
def test_only_the_owner_sees_an_interrupt_while_workers_start(tmp_path: Path, seconds: float) -> None:
    interrupt = f"threading.Timer({seconds}, os.killpg, (0, signal.SIGINT)).start()\n"
    owner = start_owner(tmp_path, interrupt + "list(LocalRunner(2).run(nap, [0.5] * 8))")
    stderr = owner.communicate(timeout=60)[1]
    assert owner.returncode != 0
    assert stderr.count("Traceback") == 1 and stderr.rstrip().endswith("KeyboardInterrupt")


def test_an_owner_that_ends_with_an_open_run_does_not_hang(tmp_path: Path) -> None:
    owner = start_owner(tmp_path, "results = LocalRunner(2).run(nap, [0.1] * 50)\nnext(results)")
    assert owner.communicate(timeout=60)[1] == ""
    assert owner.returncode == 0
