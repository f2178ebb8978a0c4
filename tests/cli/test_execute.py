"""Dry runs, JSON, exit codes, and errors on one line, as all commands have them."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from dataclasses import dataclass, replace
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest
from typer import Exit

from kinmo.cli.execute import execute, one_line_errors
from kinmo.cli.options import CommonOptions
from kinmo.core.errors import InputError
from kinmo.dataset.stage import Observer, Outcome, Plan
from kinmo.io.folder_lock import InUse


@dataclass
class Sample:
    """A stage that does nothing but report."""

    failed: int = 0
    ran: bool = False

    def plan(self) -> Plan:
        return Plan(("stir", "pour"), 120.0)

    def run(self, observer: Observer) -> Outcome:
        self.ran = True
        observer.progress("stirring", 1, 1, "tea")
        observer.note("poured")
        return Outcome(Path("cup"), {"cups": 1}, "one cup", self.failed)


def test_the_path_of_the_result_is_the_last_line_of_stdout(capsys: pytest.CaptureFixture[str]) -> None:
    execute(CommonOptions(), Sample())
    out, err = capsys.readouterr()
    assert out == "one cup\ncup\n"
    assert err == "stirring: 1/1 tea\npoured\n"


def test_no_path_is_printed_if_nothing_was_made(capsys: pytest.CaptureFixture[str]) -> None:
    class Empty(Sample):
        def run(self, observer: Observer) -> Outcome:
            return replace(super().run(observer), path=None)

    with pytest.raises(Exit):
        execute(CommonOptions(), Empty(failed=1))
    assert capsys.readouterr().out == "one cup\n"


def test_quiet_prints_the_path_alone(capsys: pytest.CaptureFixture[str]) -> None:
    execute(CommonOptions(quiet=True), Sample())
    assert capsys.readouterr() == ("cup\n", "")


@pytest.mark.parametrize("quiet", [False, True])
def test_problems_are_printed_even_if_output_is_quiet(quiet: bool, capsys: pytest.CaptureFixture[str]) -> None:
    class Spills(Sample):
        def run(self, observer: Observer) -> Outcome:
            observer.problem("spilt: a cup")
            return super().run(observer)

    with pytest.raises(Exit):
        execute(CommonOptions(quiet=quiet), Spills(failed=1))
    assert capsys.readouterr().err.splitlines()[0] == "spilt: a cup"


def test_json_prints_the_result_itself(capsys: pytest.CaptureFixture[str]) -> None:
    execute(CommonOptions(json=True), Sample())
    assert json.loads(capsys.readouterr().out) == {"cups": 1}


@pytest.mark.parametrize("dry_run", [False, True])
def test_json_is_valid_in_every_encoding_of_stdout(dry_run: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass
    class Named(Sample):
        def plan(self) -> Plan:
            return Plan(("Tür",), 0.0)

        def run(self, observer: Observer) -> Outcome:
            return Outcome(Path("Tür"), ["Tür"])

    written = BytesIO()
    with TextIOWrapper(written, "ascii", errors="backslashreplace") as stdout:  # as `main` sets it up
        monkeypatch.setattr(sys, "stdout", stdout)
        execute(CommonOptions(json=True, dry_run=dry_run), Named())
        stdout.flush()
        found = json.loads(written.getvalue())
    assert (found[0]["steps"] if dry_run else found) == ["Tür"]


def test_a_dry_run_prints_the_plan_and_runs_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    stage = Sample()
    execute(CommonOptions(dry_run=True), stage)
    assert not stage.ran
    assert capsys.readouterr().out == "stir\npour\nabout 2 min\n"


def test_a_failure_gives_exit_code_1_after_the_result(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exit) as stop:
        execute(CommonOptions(), Sample(failed=2))
    assert stop.value.exit_code == 1
    assert capsys.readouterr().out.endswith("cup\n")


@pytest.mark.parametrize(
    ("error", "line", "code"),
    [
        (InputError(Path("a.json"), "expected a\nlist", "parts"), "kinmo: a.json: parts: expected a list\n", 1),
        (InUse("w", "another kinmo is writing here"), "kinmo: w: another kinmo is writing here\n", 1),
        (KeyboardInterrupt(), "kinmo: interrupted; the same command continues from here\n", 130),
        (PermissionError(13, "Permission denied", "out"), "kinmo: out: Permission denied\n", 1),
        (ZeroDivisionError("division\nby zero"), None, 1),
    ],
)
def test_errors_are_one_line(error: BaseException, line: str | None, code: int, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exit) as stop, one_line_errors():
        raise error
    assert stop.value.exit_code == code
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert line in (None, err)


def test_an_exit_code_passes_through(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exit) as stop, one_line_errors():
        raise Exit(7)
    assert stop.value.exit_code == 7
    assert capsys.readouterr().err == ""


def test_debugging_shows_the_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("KINMO_DEBUG", "1")
    with pytest.raises(InputError), one_line_errors():
        raise InputError("x", "y")


def run_python(code: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_a_closed_pipe_ends_silently() -> None:
    code = (
        "import sys\nfrom typer import Exit\nfrom kinmo.cli.execute import one_line_errors\n"
        "try:\n  with one_line_errors():\n    sys.stdin.read()\n    print('x' * 100_000)\n"
        "except Exit as stop:\n  sys.exit(stop.exit_code)\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout and process.stdin and process.stderr
    process.stdout.close()
    process.stdin.close()
    assert process.wait(30) == 1
    assert process.stderr.read() == b""
    process.stderr.close()


@pytest.mark.skipif(os.name == "nt", reason="signals differ on Windows")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_print_one_line(number: signal.Signals) -> None:
    code = (
        "import signal, sys, time\nfrom typer import Exit\nfrom kinmo.cli.execute import one_line_errors\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # the parent may ignore it
        "try:\n  with one_line_errors():\n    print('go', flush=True)\n    time.sleep(30)\n"
        "except Exit as stop:\n  sys.exit(stop.exit_code)\n"
    )
    process = run_python(code)
    assert process.stdout is not None
    assert process.stdout.readline() == "go\n"
    process.send_signal(number)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err == "kinmo: interrupted; the same command continues from here\n"


def test_ctrl_c_during_imports_prints_one_line_too() -> None:
    code = (
        "import sys\nfrom importlib.abc import MetaPathFinder\n"
        "class Interrupting(MetaPathFinder):\n"
        "  def find_spec(self, name, path, target=None):\n"
        "    if name == 'kinmo.cli.app':\n      raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupting())\n"
        "from kinmo.cli import main\nmain()\n"
    )
    process = run_python(code)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert err == "kinmo: interrupted\n"


def test_a_dry_run_names_what_is_impossible_and_what_is_up_to_date(capsys: pytest.CaptureFixture[str]) -> None:
    class Done(Sample):
        def plan(self) -> Plan:
            return Plan((), 0.0)

    class Stuck(Sample):
        def plan(self) -> Plan:
            return Plan((), 0.0, ("row 1: cannot be run",))

    execute(CommonOptions(dry_run=True), Done())
    assert capsys.readouterr().out == "nothing: everything is up to date\n"
    execute(CommonOptions(dry_run=True), Stuck())
    assert capsys.readouterr().out == "nothing: everything that is possible is up to date\nrow 1: cannot be run\n"


def test_a_dry_run_of_what_would_fail_is_exit_code_1(capsys: pytest.CaptureFixture[str]) -> None:
    class Wrong(Sample):
        def plan(self) -> Plan:
            return Plan((), 0.0, ("cup: no such file",), 1)

    with pytest.raises(Exit) as stop:
        execute(CommonOptions(dry_run=True), Wrong())
    assert stop.value.exit_code == 1
    assert capsys.readouterr().out == "cup: no such file\n"


def test_an_unforeseen_error_says_how_to_see_more(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(Exit), one_line_errors():
        raise RuntimeError("no such axis")
    assert capsys.readouterr().err == "kinmo: internal error: RuntimeError: no such axis (KINMO_DEBUG=1 shows where)\n"
