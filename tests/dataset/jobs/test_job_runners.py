"""Behaviour that all backends share."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
from tests.dataset.jobs import example_jobs as jobs

from kinmo.core.errors import InputError
from kinmo.dataset.jobs import Failure, JobRunner, LocalRunner, RayRunner, report, runner_for


def test_an_address_chooses_the_cluster() -> None:
    assert runner_for(3) == LocalRunner(3)
    assert runner_for(3, "10.0.0.1:6379", gpus=0.25) == RayRunner("10.0.0.1:6379", 0.25)


def test_every_job_has_one_result(runner: JobRunner) -> None:
    assert sorted(runner.run(jobs.square, iter(range(40)))) == [(n, n * n) for n in range(40)]
    assert not list(runner.run(jobs.square, []))


def test_a_job_that_kills_its_process_fails_alone(runner: JobRunner) -> None:
    results = dict(runner.run(jobs.square_or_die, iter(range(6))))
    failure = results.pop(3)
    assert isinstance(failure, Failure) and failure.reason.startswith("its process died")
    assert results == {n: n * n for n in range(6) if n != 3}


def test_a_job_whose_process_died_runs_again(runner: JobRunner, tmp_path: Path) -> None:
    assert {result for _, result in runner.run(jobs.die_once, [tmp_path / "first", tmp_path / "second"])} == {"first", "second"}


def test_what_nobody_foresaw_fails_one_job(runner: JobRunner) -> None:
    results = dict(runner.run(jobs.misbehave, ["raise", "behave", "panic", "return a lock"]))
    assert results.pop("behave") == "behave"
    reasons = {how: failure.reason for how, failure in results.items()}
    assert re.fullmatch(r"ValueError at example_jobs.py:[0-9]+: not a number", reasons["raise"])
    assert re.fullmatch(r"PanicError at example_jobs.py:[0-9]+: index out of bounds", reasons["panic"])
    assert "lock" in reasons["return a lock"]


def test_what_the_user_must_mend_ends_the_run(runner: JobRunner) -> None:
    with pytest.raises(InputError, match=r"shape\.glb: expected a mesh"):
        list(runner.run(jobs.misbehave, ["behave", "raise a KinmoError", "behave"]))


def test_a_full_disk_ends_the_run(runner: JobRunner) -> None:
    with pytest.raises(OSError, match="No space left"):
        list(runner.run(jobs.misbehave, ["behave", "fill the disk", "behave"]))


def test_jobs_are_not_taken_long_before_they_run(runner: JobRunner) -> None:
    taken = []

    def numbers():
        for number in range(100):
            taken.append(number)
            yield number

    for done, _ in enumerate(runner.run(jobs.square, numbers())):
        assert len(taken) - done < 10


def test_a_job_uses_one_thread(runner: JobRunner) -> None:
    assert [result for _, result in runner.run(jobs.threads, range(4))] == [{"1"}] * 4


def test_messages_arrive_before_the_results(runner: JobRunner) -> None:
    heard = []
    for number, _ in runner.run(jobs.square_and_report, range(20), heard.append):
        assert ("at", number) in heard
    assert sorted(heard) == [("at", number) for number in range(20)]
    report("nobody listens")
    assert len(heard) == 20


def test_a_listener_that_fails_ends_the_run(runner: JobRunner) -> None:
    heard = []

    def fail(message: str) -> None:
        heard.append(message)
        raise BrokenPipeError("nobody reads")

    with pytest.raises(BrokenPipeError, match="nobody reads"):
        list(runner.run(jobs.report_much, range(8), fail))
    assert len(heard) == 1


def test_messages_of_a_worker_that_dies_arrive(runner: JobRunner) -> None:
    heard = []
    results = dict(runner.run(jobs.report_and_die, range(4), heard.append))
    assert isinstance(results[2], Failure)
    assert set(heard) == set(range(4))


def test_closing_kills_jobs_that_allow_it(runner: JobRunner, tmp_path: Path) -> None:
    results = runner.run(jobs.sleep_if_long, [tmp_path / "long", tmp_path / "short"])
    assert next(results)[0].name == "short"
    while not (tmp_path / "long").exists():
        time.sleep(0.01)
    started = time.monotonic()
    results.close()
    assert time.monotonic() - started < 200


def test_closing_drops_waiting_jobs_and_lets_running_ones_finish(runner: JobRunner, tmp_path: Path) -> None:
    results = runner.run(jobs.finish_slowly, [tmp_path / str(number) for number in range(20)])
    next(results)
    while len(list(tmp_path.glob("*.begun"))) < 2:
        time.sleep(0.01)
    results.close()
    begun = {path.stem for path in tmp_path.glob("*.begun")}
    assert begun == {path.stem for path in tmp_path.glob("*.done")}
    assert len(begun) <= 4
